"""Run the answers of a notebook, and let a judge in another process ask them.

    python answers.py         speaks with the judge by standard input and output
    python answers.py FD      forks for each submission; pipes come by the socket FD

Nothing of the judge is here: no tests, seeds, baselines, no other submission. Each line that comes
is a question in JSON, each that goes a reply. What a notebook does to this process, it does to
itself; what leads out of it, files and programs and the network, is refused, and the judge is told.
That holds against what Python knows of, not against all: a container does.
"""

import base64
import io
import os
import signal
import socket
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import IPython
import matplotlib as mpl
from IPython.core.interactiveshell import InteractiveShell
from IPython.utils.capture import capture_output
from matplotlib_inline.backend_inline import configure_inline_support
from traitlets.config import Config

import freeseg
from freeseg import teaching
from freeseg.data import DATA
from freeseg.teaching.check import answer, packed
from freeseg.teaching.own_work import refuse
from freeseg.teaching.plain import NotPlain, pack, unpack

#: What answers may import without opening a file any more, so that it costs them no time.
AT_HAND = (
    "casadi",
    "freeseg.display",
    "freeseg.maps",
    "freeseg.plotting",
    "freeseg.studies.statistics",
    "freeseg.studies.tracking",
    "freeseg.studies.tuning",
    "freeseg.trackers.mpc",
    "matplotlib.pyplot",
    "scipy.integrate",
    "scipy.interpolate",
    "scipy.linalg",
    "scipy.optimize",
    "scipy.signal",
    "scipy.spatial",
    "scipy.stats",
)
#: Longest text that a cell may print (characters).
LONGEST_OUTPUT = 20_000
#: What leads out of this process, as Python names it in audit events: families, and single ones.
FAMILIES = frozenset(
    (
        *("ctypes", "fcntl", "ftplib", "http", "mmap", "pty", "shutil", "smtplib", "socket"),
        *("sqlite3", "subprocess", "syslog", "urllib", "webbrowser", "winreg"),
    )
)
OUTWARD = frozenset(
    (
        *("os.chdir", "os.chflags", "os.chmod", "os.chown", "os.exec", "os.fchdir", "os.fork"),
        *("os.forkpty", "os.kill", "os.killpg", "os.link", "os.lockf", "os.posix_spawn"),
        *("os.putenv", "os.rename", "os.spawn", "os.startfile", "os.symlink", "os.system"),
        *("os.truncate", "os.unsetenv", "os.utime", "resource.prlimit", "resource.setrlimit"),
        *("signal.pthread_kill", "sys.addaudithook"),
    )
)
#: Those with a path, which may lead to where an answer may read or write; and of them, those that
#: change what is there.
CHANGING = frozenset(("os.mkdir", "os.remove", "os.rmdir"))
PATHS = CHANGING | {"open", "os.listdir", "os.scandir"}
#: Modules that can do so unheard.
UNHEARD = frozenset(("_posixsubprocess", "_ctypes", "_testcapi", "_testinternalcapi", "_winapi"))


def guard(folder, refused, replies):
    """Refuse from now on what leads out of this process.

    Parameters
    ----------
    folder : str
        The only one in which files may be written.
    refused : sequence of str
        Modules of freeseg whose sources may not be read.
    replies : int
        Number of the file to which is written, at once, what is refused.
    """
    package = Path(freeseg.__file__).parent
    libraries = {sys.prefix, sys.base_prefix, package, DATA, IPython.__path__[0], folder}
    libraries |= {path for path in sys.path if path.endswith("-packages")}
    readable = (*(f"{Path(path).absolute()}/" for path in libraries), "/usr/share/")
    listed = {str(Path(path).absolute()) for path in sys.path} | {path[:-1] for path in readable}
    hidden = (
        f"{package}/teaching/ps",
        f"{package}/teaching/__pycache__/ps",
        *(f"{package}/{name.removeprefix('freeseg.').replace('.', '/')}" for name in refused),
    )
    writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
    tell, paths, changing = os.write, PATHS, CHANGING
    outward, families, unheard = OUTWARD, FAMILIES, UNHEARD

    # No builtin is called here, and no name of this file, for a notebook could put others in
    # their place.
    def is_allowed(event, path, write):
        places = []
        for part in (path if path.startswith("/") else f"{folder}/{path}").split("/"):
            if part == ".." and places:
                places.pop()
            elif part not in ("", ".", ".."):
                places.append(part)
        path = f"/{'/'.join(places)}"
        if path.startswith(f"{folder}/") or path == "/dev/null":
            return True
        if write or path.startswith(hidden):
            return False
        return path.startswith(readable) or (event != "open" and path in listed)

    def hook(event, given, text=str, binary=bytes, whole=int, error=PermissionError):
        if event in paths:
            path, write = given[0], event in changing
            if event == "open" and given[2].__class__ is whole:
                write = given[2] & writing != 0
            if path.__class__ is binary:
                path = path.decode("utf-8", "replace")
            if path.__class__ is whole or path is None:
                return
            if path.__class__ is text and is_allowed(event, path, write):
                return
            what = f"{event} {path}" if path.__class__ is text else event
        elif event in outward or event.partition(".")[0] in families:
            what = event
        elif event == "import" and given[0] in unheard:
            what = f"import {given[0]}"
        else:
            return
        tell(replies, b'{"refused": "%s"}\n' % what.encode("utf-8", "replace").hex().encode())
        raise error(f"{what}: an answer reaches nothing outside of its own process")

    subprocess._fork_exec = None
    sys.modules.pop("_posixsubprocess", None)
    sys.addaudithook(hook)


class Cells:
    """Runs cells as a notebook does, and keeps what they show."""

    def __init__(self):
        config = Config()
        config.HistoryManager.enabled = False
        config.InteractiveShell.colors = "NoColor"
        self.shell = InteractiveShell.instance(config=config)
        # What it would print of an error is told in the cell's outputs.
        self.shell.showtraceback = self.shell.showsyntaxerror = lambda *_, **__: None
        self.shell.enable_gui = lambda *_: None
        self.shell.displayhook.write_output_prompt = lambda: None
        self.shell.displayhook.write_format_data = self._show
        mpl.interactive(True)
        configure_inline_support(self.shell, "inline")
        sys.modules["__main__"] = self.shell.user_module

    def _show(self, data, metadata=None):
        """Show a cell's last value, but for one that says no more than where it is in memory."""
        if len(data) > 1 or " at 0x" not in data.get("text/plain", ""):
            self.shell.display_pub.publish(data)

    def run(self, source):
        """Outputs of a cell: (kind, name or data, text)."""
        with capture_output() as shown:
            result = self.shell.run_cell(source, store_history=False)
        outputs = [
            ["stream", name, text[:LONGEST_OUTPUT]]
            for name, text in (("stdout", shown.stdout), ("stderr", shown.stderr))
            if text
        ]
        for one in shown.outputs:
            data = {kind: text(value) for kind, value in one.data.items()}
            outputs.append(["display_data", data, ""])
        if error := result.error_before_exec or result.error_in_exec:
            outputs.append(["error", type(error).__name__, str(error)[:LONGEST_OUTPUT]])
        return outputs


def text(value):
    """Data of an output as text."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    return str(value)


def serve(questions, replies):
    """Reply to all questions that come.

    Parameters
    ----------
    questions, replies : binary file
        Where they come from, and go to.
    """
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    teaching.check = lambda *_, **__: None  # the judge runs the tests
    cells, kept = Cells(), {}
    for line in questions:
        question = unpack(line, question=True)
        if question["do"] == "begin":
            os.chdir(question["folder"])
            limit(question["memory"])
            refuse(*question["refused"])
            guard(question["folder"], question["refused"], replies.fileno())
            reply = {}
        elif question["do"] == "cell":
            reply = {"outputs": cells.run(question["source"])}
        else:
            name = question["name"]
            function = kept.get(name) or cells.shell.user_ns.get(name)
            sys.stdout = sys.stderr = io.StringIO()
            found, problem = answer(function, name, question["values"])
            if not problem and question["keep"]:
                kept[f"#{len(kept)}"], found = found, f"#{len(kept)}"
            try:
                reply = {"problem": problem} if problem else {"found": unpack(packed(name, found))}
            except NotPlain as error:
                reply = {"problem": str(error)}
        replies.write(pack(reply).encode() + b"\n")
        replies.flush()


def limit(memory):
    """Limit the memory (bytes), where the system can."""
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**26, 2**26))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def host(number):
    """Fork for each pair of pipes that comes by a socket, and tell the process's number."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with socket.socket(fileno=number) as channel:
        while pipes := socket.recv_fds(channel, 1, 2)[1]:
            if child := os.fork():
                for pipe in pipes:
                    os.close(pipe)
                channel.sendall(child.to_bytes(8, "big"))
                continue
            channel.close()
            with open(pipes[0], "rb") as questions, open(pipes[1], "wb") as replies:  # noqa: PTH123
                serve(questions, replies)
            os._exit(0)


if __name__ == "__main__":
    sys.path.pop(0)  # the folder of this file, in which the course is
    for name in AT_HAND:
        try:
            import_module(name)
        except ImportError:
            continue
    if sys.argv[1:]:
        host(int(sys.argv[1]))
    else:
        with os.fdopen(os.dup(0), "rb") as first, os.fdopen(os.dup(1), "wb") as second:
            serve(first, second)
