"""Judge the answers of a notebook from outside of the process that runs them."""

import atexit
import os
import signal
import socket
import subprocess
import sys
import time
import zlib
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Timer

import nbformat
from nbgrader.preprocessors import NbGraderPreprocessor

from freeseg.teaching.check import LIMIT, Late, judge, too_long
from freeseg.teaching.own_work import REFUSED
from freeseg.teaching.plain import NotPlain, pack, unpack

ANSWERS = Path(__file__).resolve().with_name("answers.py")
#: How many times the time of a student's own check a call may take when it is graded.
PATIENCE = 3.0
#: How many times that long it may take where it sleeps, or waits for the machine; and the time (s)
#: that is enough for that, if twice that long is less.
IDLE, ASLEEP = 20.0, 180.0
#: Longest time of a cell (s), and of the start of a process.
CELL, START = 30.0, 120.0
#: Longest reply (bytes), and memory of the answers (bytes).
LONGEST_REPLY, MEMORY = 2**25, 2**32
#: With how many seeds each test is graded.
SEEDS = 2
#: What a process of answers gets to know of this one's environment.
KEPT = ("HOME", "LANG", "LC_ALL", "PATH", "PYTHONPATH", "SYSTEMROOT", "TEMP", "TMPDIR")


class Gone(AssertionError):
    """The process of the answers is no more."""


def environment():
    """What the answers' process knows of ours; one thread each, for several work at once."""
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    inline = "module://matplotlib_inline.backend_inline"
    return kept | {"MPLBACKEND": inline, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


@cache
def fork_host():
    """Socket to a process that has imported everything, and forks for each submission."""
    ours, theirs = socket.socketpair()
    told = {"env": environment(), "pass_fds": [theirs.fileno()], "stdin": subprocess.DEVNULL}
    process = subprocess.Popen([sys.executable, str(ANSWERS), str(theirs.fileno())], **told)
    theirs.close()
    atexit.register(process.kill)
    return ours


class Forked:
    """Answers in a fork of a process that has imported everything: quick to start."""

    def __init__(self):
        channel = fork_host()
        asked, self.questions = os.pipe()
        self.replies, replied = os.pipe()
        socket.send_fds(channel, [b"!"], [asked, replied])
        os.close(asked)
        os.close(replied)
        self.number = int.from_bytes(channel.recv(8), "big")
        self.questions = os.fdopen(self.questions, "wb")
        self.replies = os.fdopen(self.replies, "rb")

    def clock(self):
        """Time (s) for which it has worked: its own, however busy the machine is."""
        if sys.platform != "linux":
            return time.perf_counter()
        # The clock of another process, as clock_getcpuclockid(3) makes its number.
        return time.clock_gettime((~self.number << 3) | 2)

    def kill(self):
        """End it."""
        with suppress(ProcessLookupError):
            os.kill(self.number, signal.SIGKILL)


class Started:
    """Answers in a process of a command, such as one that starts a container."""

    def __init__(self, command):
        told = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "env": environment()}
        self.process = subprocess.Popen(command, **told)
        self.questions, self.replies = self.process.stdin, self.process.stdout

    clock = staticmethod(time.perf_counter)

    def kill(self):
        """End it."""
        self.process.kill()
        self.process.wait()


class Watch:
    """Ends a process that works longer on a question than it may.

    Parameters
    ----------
    process : Forked or Started
        It is asked now.
    limit : float
        Longest time (s) that it may work; it may sleep for longer.
    """

    def __init__(self, process, limit):
        self.process, self.limit, self.late = process, limit, False
        self.begin, self.asked = process.clock(), time.perf_counter()
        self._wait(limit)

    def _wait(self, seconds):
        self.timer = Timer(seconds, self._look)
        self.timer.daemon = True
        self.timer.start()

    def _look(self):
        try:
            left = self.limit - (self.process.clock() - self.begin)
        except OSError:
            return
        longest = max(2 * self.limit, min(IDLE * self.limit, ASLEEP))
        if left > 0 and time.perf_counter() - self.asked < longest:
            self._wait(max(left, 0.01))
            return
        self.late = True
        self.process.kill()


class Answers:
    """The cells of one submission, to run and to ask; see `freeseg.teaching.check.Ask`.

    Parameters
    ----------
    refused : tuple of str, optional
        Modules of freeseg that refuse to work for them.
    command : list of str, optional
        What starts ``answers.py``; by default it runs on this machine.

    Attributes
    ----------
    remarks : list of str
        What a lecturer should know.
    """

    patience = PATIENCE

    def __init__(self, refused=(), command=None):
        self.refused, self.command = refused, command
        self.ran, self.remarks, self.process = [], [], None
        self.folder = TemporaryDirectory(prefix="answers-")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
        self.folder.cleanup()

    def stop(self):
        """End the process, if there is one."""
        if self.process:
            self.process.kill()
            for stream in (self.process.questions, self.process.replies):
                with suppress(OSError):
                    stream.close()
            self.process = None

    def _start(self):
        """A process in which all cells ran that had run before."""
        if self.command or not hasattr(os, "fork"):
            self.process = Started(self.command or [sys.executable, str(ANSWERS)])
        else:
            self.process = Forked()
        folder = "/tmp" if self.command else self.folder.name
        begin = {"do": "begin", "folder": folder, "refused": self.refused, "memory": MEMORY}
        self._send(begin, START)
        for source in self.ran:
            try:
                self._send({"do": "cell", "source": source}, CELL)
            except (Late, Gone) as error:
                # It ran once and does so no more: it is not tried again.
                self._stopped(error, source)
                self.ran.remove(source)
                self._start()
                break

    def _send(self, question, limit):
        """The reply to a question; `Gone` or `Late` where there is none."""
        watch = Watch(self.process, limit)
        try:
            self.process.questions.write(pack(question).encode() + b"\n")
            self.process.questions.flush()
            reply = self._read()
            while isinstance(reply, dict) and list(reply) == ["refused"]:
                what = bytes.fromhex(reply["refused"]).decode("utf-8", "replace")
                self._note(f"tried to reach out of its process: {what:.200}")
                reply = self._read()
        except (OSError, ValueError, TypeError, NotPlain):
            reply = None
        finally:
            watch.timer.cancel()
        if not isinstance(reply, dict):
            self.stop()
            raise Late if watch.late else Gone("your code ended Python, or spoke in its place")
        return reply

    def _read(self):
        """What the process says next."""
        line = self.process.replies.readline(LONGEST_REPLY)
        return unpack(line) if line.endswith(b"\n") else None

    def _note(self, remark):
        if remark not in self.remarks:
            self.remarks.append(remark)

    def clock(self):
        """See `freeseg.teaching.check.Ask`."""
        return self.process.clock() if self.process else 0.0

    def _stopped(self, error, source, name=""):
        """Remark on a cell that was ended, by its name or its first line; what is said of it."""
        first_line = source.strip().partition("\n")[0]
        what = f"cell {name or repr(first_line[:40])}"
        told = f"{what} ended Python: what it defines is missing"
        if isinstance(error, Late):
            told = (
                f"{what} did not end within {CELL:g} s and was stopped, so that what it defines is "
                "missing: is there a loop that does not end?"
            )
        self._note(told)
        return told

    def run(self, source, name=""):
        """Outputs of a cell, which later questions find run."""
        try:
            if not self.process:
                self._start()
            reply = self._send({"do": "cell", "source": source}, CELL)
        except (Late, Gone) as error:
            told = {"ename": type(error).__name__, "evalue": self._stopped(error, source, name)}
            return [nbformat.v4.new_output("error", traceback=[told["evalue"]], **told)]
        self.ran.append(source)
        return [output for one in reply.get("outputs") or () for output in _output(one)]

    def __call__(self, name, *values, limit=LIMIT, keep=False):
        """See `freeseg.teaching.check.Ask`."""
        if not self.process:
            if name.startswith("#"):
                raise Gone("your law is gone: it took too long, or ended Python")
            self._start()
        question = {"do": "call", "name": name, "values": values, "keep": keep}
        try:
            reply = self._send(question, max(limit, 0.01) * PATIENCE)
        except Late:
            raise Late(too_long(limit)) from None
        if reply.get("problem"):
            raise AssertionError(str(reply["problem"])[:2000])
        return reply.get("found")


def _output(one):
    """An output in nbformat's form, of what came from the answers; none of what is no output."""
    match one:
        case ["stream", "stdout" | "stderr" as name, str(text)]:
            yield nbformat.v4.new_output("stream", name=name, text=text)
        case ["display_data", dict(data), _]:
            kept = {str(kind): str(value) for kind, value in data.items()}
            yield nbformat.v4.new_output("display_data", data=kept)
        case ["error", str(name), str(text)]:
            told = {"ename": name, "evalue": text, "traceback": [f"{name}: {text}"]}
            yield nbformat.v4.new_output("error", **told)


def seeds_of(test, secret):
    """Seeds with which a test is graded, which nobody knows who does not know the secret."""
    return [zlib.crc32(f"{secret}\n{test}\n{k}".encode()) for k in range(SEEDS)]


def judge_notebook(notebook, name, secret, command=None):
    """Fill in the outputs of a notebook, those of tests by what the judge says.

    Parameters
    ----------
    notebook : NotebookNode
        The released notebook with a student's answers.
    name : str
        The set's, such as "ps1_kinematics_and_segments".
    secret : str
        From which the tests' seeds are made.
    command : list of str, optional
        As for `Answers`.

    Returns
    -------
    list of str
        Remarks.
    """
    part = name.partition("_")[0]
    with Answers(REFUSED.get(part, ()), command) as answers:
        for cell in notebook.cells:
            known = cell.metadata.get("nbgrader") or {}
            if cell.cell_type != "code":
                continue
            if not known.get("grade") or known.get("solution"):
                cell.outputs = answers.run(cell.source, known.get("grade_id", ""))
                continue
            test = f"{part}.{known['grade_id']}"
            share, said = judge(test, answers, seeds_of(test, secret))
            if "your code takes over" in said or "longer than the robot drives" in said:
                answers.remarks.append(f"{test} was ended by its time limit")
            elif "your code ended Python" in said:
                answers.remarks.append(f"{test} ended Python")
            points = round(share * known["points"], 2)
            result = {"data": {"text/plain": repr(points)}, "execution_count": None}
            cell.outputs = [
                nbformat.v4.new_output("stream", name="stdout", text=f"{said}\n"),
                nbformat.v4.new_output("execute_result", **result),
            ]
        return answers.remarks


def judged(*given):
    """Outputs of all cells of a notebook by their ids, and remarks; as for `judge_notebook`."""
    remarks = judge_notebook(*given)
    return {cell.id: cell.outputs for cell in given[0].cells if "outputs" in cell}, remarks


class Judge(NbGraderPreprocessor):
    """Stands for nbgrader's Execute: the answers run elsewhere, and the judge fills in outputs."""

    #: What starts the answers in a container, or None; and what was judged beforehand: outputs of
    #: cells by their ids, and remarks, by set and student.
    command, done = None, {}

    def preprocess(self, nb, resources):
        """Judge a notebook; what a lecturer should know is kept in its metadata."""
        name, student = (resources["nbgrader"][key] for key in ("assignment", "student"))
        if (name, student) in self.done:
            outputs, nb.metadata["remarks"] = self.done[name, student]
            for cell in nb.cells:
                if cell.cell_type == "code":
                    cell.outputs = outputs.get(cell.id, [])
            return nb, resources
        root = Path(self.parent.parent.coursedir.root)
        secret = (root / "build" / "secret.txt").read_text(encoding="utf-8")
        nb.metadata["remarks"] = judge_notebook(nb, name, secret, self.command)
        return nb, resources
