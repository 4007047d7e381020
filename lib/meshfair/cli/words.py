"""Messages of the package, which speak of Python, in the words of the command line."""

import re

# What has a form on the command line, or is a noun there. Whole names only, since files have names
# such as mesh.stl.
PHRASES = {
    "fixed=mesh.boundary_vertices(F)": "--fix-boundary",
    'weights.cotangent(V, F, negative="clamp")': "clamped cotangent weights in Python",
    "intrinsic.cotangent": "meshfair.intrinsic.cotangent in Python",
    "operators.boundary_as_curve": "meshfair.operators.boundary_as_curve in Python",
    'parameters="auto"': "--auto",
    "weld=False": "--no-weld",
    "mesh.inspect": "meshfair info",
    "mesh.repair": "meshfair repair",
    "noise.along_normals": "meshfair noise --model normals",
    "noise.gaussian": "meshfair noise --model gaussian",
    "noise.uniform": "meshfair noise --model uniform",
    "flow.heat": "denoise --method heat",
    "flow.average": "denoise --method averaging",
    "weights.combinatorial": "--weights combinatorial",
    "weights.distance": "--weights distance",
    "weights.cotangent": "--weights cotangent",
    "mesh.area": "the area",
    "mesh.volume": "the volume",
    "mesh.vertex_normals": "the vertex normals",
    "metrics.normal_angle": "the normal angle",
    "metrics.snr": "the SNR",
    "operators.mass": "the mass matrix",
    "operators.diffusion": "diffusion",
}
_PHRASE = re.compile(rf"(?<![\w/.])({'|'.join(map(re.escape, PHRASES))})(?![\w/(]|\.\w)")
_REPAIR = re.compile(r"mesh\.repair\(V, F((?:, \w+=[\w\".]+)*)\)")
_KEYWORD = re.compile(r'(?<!--set )(?<![\w.-])(\w+)=("[\w-]+"|True|[\d.]+)')
# With what a message begins, where no option gives it.
SUBJECTS = {
    "V": "the mesh",
    "V, F": "the mesh",
    "V_true": "the ground truth",
    "displacement": "the noise",
}
_SUBJECT = re.compile(r"\A(?:V, F|V)(?=: )|\A\w+(?= (?:is|has|holds|needs|scales) )")
_STEP = re.compile(r"(?<=, so )(\w+)(?= would )|(?<=; give a smaller )(\w+)$")


def in_words_of_the_command(message: str, option_of: dict[str, str]) -> str:
    """A message with options where it has names of Python.

    Parameters
    ----------
    message : str
    option_of : dict of str
        The option for each argument's name, such as "--noise" for "sigma".

    Returns
    -------
    str
    """

    def keyword(match: re.Match[str]) -> str:
        name, value = match.group(1), match.group(2).strip('"')
        return _option(option_of[name], value) if name in option_of else match.group()

    message = _REPAIR.sub(_repair, message)
    message = _PHRASE.sub(lambda match: PHRASES[match.group()], message)
    message = _KEYWORD.sub(keyword, message)
    named = SUBJECTS | option_of

    def option(match: re.Match[str]) -> str:
        return named.get(match.group(), match.group())

    return _STEP.sub(option, _SUBJECT.sub(option, message, count=1))


def _repair(match: re.Match[str]) -> str:
    """The call of mesh.repair as a command."""
    steps = (step.split("=") for step in match.group(1).removeprefix(", ").split(", "))
    options = (_option(f"--{name}", value.strip('"')) for name, value in steps)
    return f"meshfair repair {' '.join(options)}"


def _option(name: str, value: str) -> str:
    return name if value == "True" else f"{name} {value}"
