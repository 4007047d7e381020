"""A student's functions as the checks see them: ``student.edges(F)`` asks for an answer.

`NotebookStudent` asks the module that the notebook has imported. `IsolatedStudent`
asks a process with limits, and starts another one when it has died.
"""

import importlib
import signal
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any, Self

from meshfair_grading import protocol
from meshfair_grading.answers import Answer, Failure, ask, failure
from meshfair_grading.arguments import Lent
from meshfair_grading.expect import WrongAnswerError
from meshfair_grading.isolation import Isolation, Process
from meshfair_grading.loading import MOST_REMARKS
from meshfair_grading.rules import Rules, read


class NotDoneError(Exception):
    """The function is still the stub."""


class Student:
    """Base of both: turns answers into values, and failures into `WrongAnswerError`."""

    def __init__(self) -> None:
        self.changed: list[tuple[str, int]] = []
        """Function and index of each argument that the current check's calls changed."""
        self.check = self.case = ""
        """What is being checked, and on what."""
        self.replaced: tuple[str, ...] = ()
        """Functions that are not the student's own."""
        self.calls: dict[str, list[str]] = {}
        """By function: the functions of the student's file that it names."""
        self._answers: dict[tuple[Any, ...], tuple[tuple[Any, ...], Answer]] = {}

    def _ask(self, name: str, arguments: tuple[Any, ...]) -> Answer:
        raise NotImplementedError

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name.startswith("_"):
            raise AttributeError(name)

        def call(*arguments: Any) -> Any:
            return self._value(name, arguments, self._ask(name, arguments))

        return call

    def once(self, name: str, *arguments: Any) -> Any:
        """A function's value, asked for only the first time: for slow functions.

        Parameters
        ----------
        name : str
        arguments : objects
            The same objects, and not only equal ones, give the value of before.
        """
        key = (name, *map(id, arguments))
        if key not in self._answers:
            # The arguments are kept too, so that no other object gets one of their ids.
            self._answers[key] = arguments, self._ask(name, arguments)
        return self._value(name, *self._answers[key])

    def _value(self, name: str, arguments: tuple[Any, ...], answer: Answer) -> Any:
        if answer.failure is not None:
            raise _explained(name, answer.failure)
        if answer.value is None:
            raise WrongAnswerError(
                f"`{name}` returns nothing: is the `return` missing?",
                expected="a value",
                got="None",
            )
        self.changed += [(name, index) for index in answer.changed if index < len(arguments)]
        return answer.value


def _explained(name: str, failure: Failure) -> Exception:
    """The exception that a check ends with when there is no value."""
    if failure.kind == "not done":
        return NotDoneError(f"`{failure.message}` is not done yet")
    got = f"line {failure.line}: {failure.code}" if failure.line else failure.kind
    openings = {
        "missing": f"There is no function `{name}`: keep the names of the stub.",
        "raised": f"`{name}` ended with {failure.message}",
        "not loaded": f"The file could not be loaded: {failure.message}",
        "not allowed": f"The assignment does not allow {failure.message}.",
        "time limit": f"`{name}` ran out of time ({failure.message}): is there an endless loop?",
        "crashed": f"`{name}` {failure.message}",
    }
    return WrongAnswerError(
        openings.get(failure.kind, failure.message), expected="a value", got=got
    )


class NotebookStudent(Student):
    """The functions of a module that the student edits and imports.

    Parameters
    ----------
    module : str
        Its name; imported when first asked. ``__main__`` is the notebook itself.
    rules : meshfair_grading.rules.Rules
    """

    def __init__(self, module: str, rules: Rules) -> None:
        super().__init__()
        self._failures: dict[str, Failure] = {}
        self._module: ModuleType | None = None
        self._file = ""
        try:
            self._module = sys.modules.get(module) or importlib.import_module(module)
            self._file = getattr(self._module, "__file__", None) or ""
            if self._file:
                reading = read(Path(self._file).read_bytes(), rules)
                self._failures, self.calls = reading.failures, reading.calls
        except Exception as error:  # whatever the student's module raises
            self._module, self._file = None, ""
            line = traceback.extract_tb(error.__traceback__)[-1].lineno or 0
            self._failures = {"": Failure("not loaded", failure(error, "").message, line)}

    def _ask(self, name: str, arguments: tuple[Any, ...]) -> Answer:
        broken = self._failures.get("") or self._failures.get(name)
        if broken:
            return Answer(failure=broken)
        function = getattr(self._module, name, None)
        if not callable(function):
            return Answer(failure=Failure("missing", name))
        return ask(function, arguments, self._file)


class IsolatedStudent(Student):
    """The functions of a file that was handed in, in a process of their own.

    Parameters
    ----------
    source : bytes
        The file.
    assignment : str
        Its name without ``.py``.
    rules : meshfair_grading.rules.Rules
    isolation : meshfair_grading.isolation.Isolation

    Attributes
    ----------
    printed : str
        The beginning of what the code printed.
    remarks : list of str
        What of the file was left out.
    """

    def __init__(self, source: bytes, assignment: str, rules: Rules, isolation: Isolation) -> None:
        super().__init__()
        self.printed = ""
        self.remarks: list[str] = []
        self._source, self._assignment = source, assignment
        self._rules, self._isolation = rules, isolation
        self._left = isolation.limits.total
        self._process: Process | None = None
        self._failures: dict[str, Failure] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stop()

    @property
    def left(self) -> float:
        """Seconds that the submission may still use."""
        return max(self._left, 0.0)

    @property
    def whole_file(self) -> Failure | None:
        """Why no function could be asked at all, or None."""
        return self._failures.get("")

    def _ask(self, name: str, arguments: tuple[Any, ...]) -> Answer:
        if self._process is None and "" not in self._failures:
            self._start()
        broken = self._failures.get("") or self._failures.get(name)
        if broken:
            return Answer(failure=broken)
        with closing(Lent(arguments)) as lent:
            reply, lost = self._exchange({"call": name, "arguments": lent.layout}, lent)
            if isinstance(reply, Answer):
                # What it says of its own accord is what only it can see, such as a matrix
                # whose arrays are other ones now.
                return replace(reply, changed=tuple({*reply.changed, *lent.changed()}))
        # The same call would end the same way; the other functions get a new process.
        self._failures[name] = lost or Failure("crashed", "sent an invalid message")
        return Answer(failure=self._failures[name])

    def _start(self) -> None:
        self._process = self._isolation.start(
            self._source, f"{self._assignment}.py", self._rules.allowed, self._rules.blocked
        )
        request = {
            "load": self._process.file,
            "allowed": list(self._rules.allowed),
            "forbidden": list(self._rules.forbidden),
            "blocked": list(self._rules.blocked),
        }
        reply, lost = self._exchange(request)
        if lost is not None:
            slow = f"running it took longer than {lost.message}"
            text = slow if lost.kind == "time limit" else f"the process {lost.message}"
            self._failures[""] = Failure("not loaded", text)
        elif isinstance(reply, dict):
            self._hear(reply)
        if "" in self._failures:
            self._stop()

    def _hear(self, said: dict[str, Any]) -> None:
        """Take in what the child says about the file; it need not be the truth."""
        failures, remarks, calls = (said.get(key) for key in ("failures", "remarks", "calls"))
        if isinstance(failures, dict):
            self._failures |= {k: v for k, v in failures.items() if isinstance(v, Failure)}
        if isinstance(remarks, list) and not self.remarks:
            self.remarks = [str(remark) for remark in remarks[:MOST_REMARKS]]
        if isinstance(calls, dict):
            self.calls = {k: [str(n) for n in v] for k, v in calls.items() if isinstance(v, list)}

    def _exchange(
        self, request: dict[str, Any], lent: Lent | None = None
    ) -> tuple[Any, Failure | None]:
        """Send a request and wait for the reply: (reply, why the process is lost)."""
        limits = self._isolation.limits
        if self._process is None or self._left <= 0:
            self._stop()
            return None, Failure("time limit", f"{limits.total:g} s for all")
        start = time.monotonic()
        deadline = start + min(limits.call, self._left)
        channel = self._process.channel
        try:
            channel.settimeout(deadline - start)
            protocol.send(channel, request)
            if lent is not None:
                lent.send(channel)
            return protocol.receive(channel, deadline), None
        except TimeoutError:
            self._stop()
            return None, Failure("time limit", f"{limits.call:g} s")
        except protocol.ProtocolError as error:
            self._stop()
            return None, Failure("crashed", f"disturbed its channel: {error}")
        except (EOFError, OSError):
            # It has closed the channel, so its end is near: its exit code tells why.
            code, excess = self._stop(patience=2.0)
            return None, Failure("crashed", excess or _death(code))
        finally:
            # Only the student's time counts, not what the checks take in between.
            self._left -= time.monotonic() - start

    def _stop(self, patience: float = 0.0) -> tuple[int | None, str]:
        """End the process, keep what it printed: its exit code, and what it used too much of."""
        if self._process is None:
            return None, ""
        process, self._process = self._process, None
        code, printed, excess = process.stop(patience)
        self.printed = self.printed or printed
        return code, excess


def _death(code: int | None) -> str:
    """How a process ended, in words, from its exit code."""
    if code is None or code >= 0:
        return f"ended the process itself (exit code {code}): a function returns, it does not exit"
    names: dict[int, str] = {
        signal.SIGSEGV: "crashed with a segmentation fault",
        signal.SIGABRT: "was aborted by a library",
        signal.SIGXCPU: "used up its processor time",
        signal.SIGKILL: "was killed by the system: too much processor time or memory",
    }
    return names.get(-code, f"was ended by signal {-code}")
