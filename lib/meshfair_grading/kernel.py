"""Which calls to the kernel a submission's process may not make: a filter for bubblewrap.

What is refused is not needed to compute, and leads around a limit or a wall: memory that
belongs to no process and so is not counted, keyrings and machines outside that no namespace
hides, namespaces of one's own.
"""

import errno
import platform
import struct
from collections.abc import Iterator

# Numbers on x86-64 and on 64-bit ARM.
REFUSED = {
    # Keyrings are the user's, within the walls as well.
    "add_key": (248, 217), "request_key": (249, 218), "keyctl": (250, 219),
    # Memory, or messages, of no process.
    "memfd_create": (319, 279), "memfd_secret": (447, 447), "shmget": (29, 194),
    "msgget": (68, 186), "semget": (64, 190), "mq_open": (240, 180),
    # Other processes' memory and files.
    "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271),
    "pidfd_getfd": (438, 438), "kcmp": (312, 272), "open_by_handle_at": (304, 265),
    "name_to_handle_at": (303, 264),
    # New walls within the walls, and mounts.
    "unshare": (272, 97), "setns": (308, 268), "mount": (165, 40), "umount2": (166, 39),
    "pivot_root": (155, 41), "chroot": (161, 51), "open_tree": (428, 428),
    "move_mount": (429, 429), "fsopen": (430, 430), "fsmount": (432, 432),
    "mount_setattr": (442, 442),
    # Large parts of the kernel that nobody needs here.
    "bpf": (321, 280), "perf_event_open": (298, 241), "userfaultfd": (323, 282),
    "io_uring_setup": (425, 425), "io_uring_enter": (426, 426), "io_uring_register": (427, 427),
    "fanotify_init": (300, 262), "init_module": (175, 105), "finit_module": (313, 273),
    "kexec_load": (246, 104), "syslog": (103, 116), "quotactl": (179, 60), "acct": (163, 89),
    "swapon": (167, 224), "reboot": (169, 142), "settimeofday": (164, 170),
    "clock_settime": (227, 112), "adjtimex": (159, 171), "clock_adjtime": (305, 266),
}  # fmt: skip
CLONE, CLONE3, SOCKET, MMAP = (56, 220), (435, 435), (41, 198), (9, 222)
# The processors' names, their places in the tuples above, and the kernel's numbers for them.
PROCESSORS = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}
NEW_NAMESPACES = 0x7E020000
FAMILIES = (1, 2, 10)  # of sockets: local, IPv4, IPv6
SHARED_WITHOUT_FILE = 0x21
OTHER_NUMBERS = 0x40000000  # on x86-64: the same calls once more

LOAD, EQUAL, AT_LEAST, ANY_BIT, AND, RETURN = 0x20, 0x15, 0x35, 0x45, 0x54, 0x06
NUMBER, PROCESSOR, ARGUMENTS = 0, 4, 16  # places in what is filtered
ALLOW, REFUSE, KILL = 0x7FFF0000, 0x00050000, 0x80000000


def program() -> bytes:
    """The filter for this machine's processor.

    Returns
    -------
    bytes
        A program of the kernel's packet filter; empty for other processors.
    """
    if platform.machine() not in PROCESSORS:
        return b""
    place, number = PROCESSORS[platform.machine()]
    return b"".join(struct.pack("<HBBI", *step) for step in _steps(place, number))


def _steps(place: int, processor: int) -> Iterator[tuple[int, int, int, int]]:
    """Each: what to do, how many steps to skip if so and if not, and with what."""
    yield LOAD, 0, 0, PROCESSOR
    yield EQUAL, 1, 0, processor
    yield RETURN, 0, 0, KILL
    yield LOAD, 0, 0, NUMBER
    yield AT_LEAST, 0, 1, OTHER_NUMBERS
    yield RETURN, 0, 0, REFUSE | errno.ENOSYS
    for numbers in REFUSED.values():
        yield EQUAL, 0, 1, numbers[place]
        yield RETURN, 0, 0, REFUSE | errno.EPERM
    # Its arguments cannot be looked at; libraries then take the older call.
    yield EQUAL, 0, 1, CLONE3[place]
    yield RETURN, 0, 0, REFUSE | errno.ENOSYS
    yield EQUAL, 0, 4, CLONE[place]
    yield LOAD, 0, 0, ARGUMENTS
    yield ANY_BIT, 0, 1, NEW_NAMESPACES
    yield RETURN, 0, 0, REFUSE | errno.EPERM
    yield RETURN, 0, 0, ALLOW
    yield EQUAL, 0, 3 + len(FAMILIES), SOCKET[place]
    yield LOAD, 0, 0, ARGUMENTS
    for position, family in enumerate(FAMILIES):
        yield EQUAL, len(FAMILIES) - position, 0, family
    yield RETURN, 0, 0, REFUSE | errno.EAFNOSUPPORT
    yield RETURN, 0, 0, ALLOW
    yield EQUAL, 0, 5, MMAP[place]
    yield LOAD, 0, 0, ARGUMENTS + 3 * 8
    yield AND, 0, 0, SHARED_WITHOUT_FILE
    yield EQUAL, 0, 1, SHARED_WITHOUT_FILE
    yield RETURN, 0, 0, REFUSE | errno.EPERM
    yield RETURN, 0, 0, ALLOW
    yield RETURN, 0, 0, ALLOW
