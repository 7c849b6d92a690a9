#!/usr/bin/env python3
"""Injects a fault into runs and sweeps at seeded moments, and requires that nothing is lost.

    faults.py PICKBED FAULT CASES SEED

Each case starts `pickbed run` or `pickbed sweep` with two workers, injects the fault, and repeats the command
with --resume. Trials that were stored before are kept and not repeated, no trial is missing or doubled, and
all results are, byte by byte, those of an undisturbed run. FAULT is one of

    kill_group       SIGKILL to all processes
    kill_parent      SIGKILL to the parent; its workers end by themselves
    kill_worker      SIGKILL to one worker; the run goes on by itself
    terminate        SIGTERM to the parent
    terminate_group  SIGTERM to all processes, as Slurm sends it
    full_disk        a disk of seeded size, which then gets room
    clock_back       as kill_group, and the clock is 400 days earlier when the command is repeated
    clock_forward    as kill_group, and the clock is 400 days later when the command is repeated
    memory_limit     SIGKILL to all workers, again and again, as at a memory limit
    two_writers      the same command is started a second time
    lost_node        a sweep in three shards, and one of them is killed with all its processes
    slow_folder      a shared folder in which calls take up to 20 ms, and new files of other processes are seen late
    stale_handle     a shared folder in which one call fails with "Stale file handle"
    io_error         as stale_handle, with "Input/output error"
    read_only        a shared folder in which nothing can be written any more

The last four need the library slow_folder.cpp, which PICKBED_SLOW_FOLDER names.

Exit status 77: this machine does not permit the fault, with the reason on stderr.
"""

import filecmp
import errno
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
INTERRUPTED = 130
BAD_INPUT = 1
LIMIT_S = 300  # of one command; only a hang takes so long
DISK_BYTES = 64 << 20
FAILING_CALLS = {"stale_handle": errno.ESTALE, "io_error": errno.EIO, "read_only": errno.EROFS}
CLOCKS = {"clock_back": ("faketime", "-f", "-400d"), "clock_forward": ("faketime", "-f", "+400d")}
SHARDS = 3

SCENARIO = """\
seed: 7
trials: 4
objects: [{name: rod, count: 2}]
estimator: {name: oracle, noise_mm: 1}
"""
SWEEP = """\
scenario: small.yaml
trials: 2
grid: {estimator.noise_mm: [1, 9]}
"""
# Times, and the store, whose rows are compared instead.
NOT_COMPARED = {"timings.csv", "lock", "results.sqlite", "results.sqlite-journal", "results.sqlite-wal",
                "results.sqlite-shm"}


class Failed(Exception):
    """A case did not behave as it must."""


def require(condition, message):
    if not condition:
        raise Failed(message)


class Command:
    """`pickbed run` or `pickbed sweep` into a folder, in a process group of its own."""

    def __init__(self, pickbed, kind, work):
        self.kind = kind
        self.work = work
        self.arguments = [pickbed, kind, f"{'small' if kind == 'run' else 'sweep'}.yaml", "--jobs", "2",
                          "--pictures", "1"]

    def start(self, out, *more, clock=(), variables=None, stderr="stderr.txt"):
        errors = open(self.work / stderr, "w")
        return subprocess.Popen([*clock, *self.arguments, "--out", out, *more], cwd=self.work, start_new_session=True,
                                stdout=subprocess.DEVNULL, stderr=errors, env={**os.environ, **(variables or {})})

    def finish(self, out, *more, clock=(), variables=None):
        """Runs the command to its end and returns its exit status. `clock`: a program that changes the clock."""
        return wait(self.start(out, *more, clock=clock, variables=variables))

    def error_lines(self, stderr="stderr.txt"):
        """The lines on stderr that are no progress."""
        lines = (self.work / stderr).read_text().splitlines()
        return [line for line in lines if line.startswith("pickbed: ")]


def wait(process):
    """Waits for the process and all others of its group. Returns the exit status."""
    status = process.wait(LIMIT_S)
    deadline = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline:
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return status
        time.sleep(0.01)
    raise Failed("processes of the run do not end")


def workers_of(pid):
    try:
        return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except FileNotFoundError:
        return []


def rows(folder, with_times=False):
    """All rows of a store, by table; {} without a store. It reads a copy, because reading repairs a store."""
    if not (folder / "results.sqlite").exists():
        return {}
    with tempfile.TemporaryDirectory() as copy:
        for file in folder.glob("results.sqlite*"):
            shutil.copy(file, copy)
        database = sqlite3.connect(pathlib.Path(copy) / "results.sqlite")
        names = [name for name, in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        tables = {name: sorted(database.execute(f"SELECT * FROM {name}"), key=repr) for name in names}
        database.close()
    if not with_times:
        tables.pop("timings", None)
    return tables


def trials(tables):
    return sorted(row[0] for row in tables.get("trials", []))


def files(folder):
    return {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}


def require_same(out, whole):
    """Requires the rows and files of an undisturbed run."""
    numbers = trials(rows(out))
    require(len(set(numbers)) == len(numbers), f"doubled trials: {numbers}")
    require(numbers == trials(rows(whole)), f"not all trials: {numbers}")
    require(rows(out) == rows(whole), "other rows in the store")
    names, expected = files(out) - NOT_COMPARED, files(whole) - NOT_COMPARED
    require(names == expected, f"other files: {sorted(names ^ expected)}")
    for name in names:
        require(filecmp.cmp(out / name, whole / name, shallow=False), f"{name} differs")


def require_kept(before, out):
    """Requires that the trials stored before are still there, with the times of their only execution."""
    after = rows(out, with_times=True)
    for table in ("trials", "timings"):
        gone = set(map(repr, before.get(table, []))) - set(map(repr, after[table]))
        require(not gone, f"{len(gone)} earlier rows of table {table} are gone, such as {next(iter(gone), '')}")


def signal_at(process, fault, moment_s, rng):
    """Sends the signal of the fault at a moment, or as soon as there is a worker."""
    time.sleep(moment_s)
    if fault == "kill_worker":
        while process.poll() is None:
            workers = workers_of(process.pid)
            if workers:
                os.kill(rng.choice(workers), signal.SIGKILL)
                return
            time.sleep(0.005)
        return
    number = signal.SIGTERM if fault.startswith("terminate") else signal.SIGKILL
    if process.poll() is not None:
        return
    if fault.endswith("_group") or fault in CLOCKS:
        os.killpg(process.pid, number)
    else:
        os.kill(process.pid, number)


def signal_case(command, fault, whole, out, duration_s, rng):
    moment_s = rng.uniform(0, duration_s)
    process = command.start(out.name)
    signal_at(process, fault, moment_s, rng)
    status = wait(process)
    lines = command.error_lines()
    # Before main() the signals still have their usual effect, and the folder is not yet there.
    early = not out.exists() and status == -signal.SIGTERM
    expected = {"kill_group": {0, -signal.SIGKILL}, "kill_parent": {0, -signal.SIGKILL}, "kill_worker": {0},
                **{clock: {0, -signal.SIGKILL} for clock in CLOCKS}}
    require(early or status in expected.get(fault, {0, INTERRUPTED}), f"exit status {status}: {lines}")
    require(len(lines) <= 1, f"more than one line: {lines}")
    before = rows(out, with_times=True)
    if status == INTERRUPTED and trials(before):
        require(lines and "--resume" in lines[0] or lines == ["pickbed: interrupted"], f"no advice: {lines}")
    status = command.finish(out.name, "--resume", clock=CLOCKS.get(fault, ()))
    require(status == 0, f"exit status {status} of --resume: {command.error_lines()}")
    require_kept(before, out)
    require_same(out, whole)
    return f"after {moment_s:.2f} s with {len(trials(before))} trials"


def disk_case(command, whole, out, size, rng):
    """Runs on a disk that becomes full, tries again, makes room and resumes."""
    disk_bytes = rng.randrange(8 << 10, size, 4 << 10)
    out.mkdir()
    mount = lambda options: subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", out], check=True)
    mount(f"size={disk_bytes}")
    try:
        for arguments in ([], ["--resume"]):
            status = command.finish(out.name, *arguments)
            lines = command.error_lines()
            require(status == BAD_INPUT, f"exit status {status} on a disk of {disk_bytes} bytes: {lines}")
            require(len(lines) == 1 and f"{out.name}/" in lines[0], f"not one line with the file: {lines}")
            require("No space left" in lines[0] or "is full" in lines[0], f"not called full: {lines}")
            before = rows(out, with_times=True)
        mount(f"remount,size={DISK_BYTES}")
        status = command.finish(out.name, "--resume")
        require(status == 0, f"exit status {status} of --resume: {command.error_lines()}")
        require_kept(before, out)
        require_same(out, whole)
    finally:
        subprocess.run(["umount", out], check=True)
    return f"full at {disk_bytes >> 10} kB with {len(trials(before))} trials"


def memory_case(command, whole, out, duration_s, rng):
    """From a moment on, each worker is killed. The command is repeated with --resume --retry-crashed."""
    moment_s = rng.uniform(0, duration_s)
    process = command.start(out.name)
    time.sleep(moment_s)
    killed = 0
    while process.poll() is None:
        for worker in workers_of(process.pid):
            try:
                os.kill(worker, signal.SIGKILL)
                killed += 1
            except ProcessLookupError:
                pass  # it ended by itself
        time.sleep(0.02)
    status = wait(process)
    lines = command.error_lines()
    require(status in (0, BAD_INPUT), f"exit status {status}: {lines}")
    require(status == 0 or len(lines) == 1 and "memory" in lines[0], f"not one line about memory: {lines}")
    before = rows(out, with_times=True)
    # A bin whose workers were killed twice is stored as crashed, and --retry-crashed replaces it.
    before["trials"] = [row for row in before.get("trials", []) if "crashed" not in row]
    status = command.finish(out.name, "--resume", "--retry-crashed")
    require(status == 0, f"exit status {status} of --resume: {command.error_lines()}")
    require_kept(before, out)
    require_same(out, whole)
    return killed > 0, f"{killed} workers killed after {moment_s:.2f} s with {len(trials(before))} trials"


def two_writers_case(command, whole, out, duration_s, rng):
    """A second command of the same kind, with or without --resume, while the first one works."""
    moment_s = rng.uniform(0, duration_s)
    resume = ["--resume"] if rng.random() < 0.5 else []
    first = command.start(out.name)
    time.sleep(moment_s)
    is_working = first.poll() is None
    second = command.start(out.name, *resume, stderr="second.txt")
    status = {"stderr.txt": wait(first), "second.txt": wait(second)}
    for name in status:
        lines = command.error_lines(name)
        require(status[name] in (0, BAD_INPUT), f"exit status {status[name]}: {lines}")
        require(status[name] == 0 or len(lines) == 1 and out.name in lines[0], f"not one line with the folder: {lines}")
    require(0 in status.values(), "both were refused")
    require_same(out, whole)
    refused = command.error_lines("second.txt") or command.error_lines()
    return is_working and len(refused) > 0, f"second after {moment_s:.2f} s{' with --resume' if resume else ''}: {refused}"


def lost_node_case(command, whole, out, duration_s, rng):
    """Shards that run one after the other. One is killed, and its command is repeated as Slurm's job does."""
    lost = rng.randrange(1, SHARDS + 1)
    moment_s = rng.uniform(0, duration_s / SHARDS)
    for shard in range(1, SHARDS + 1):
        arguments = ["--shard", f"{shard}/{SHARDS}"]
        process = command.start(out.name, *arguments)
        if shard == lost:
            signal_at(process, "kill_group", moment_s, rng)
        status = wait(process)
        require(status == 0 or shard == lost, f"exit status {status} of shard {shard}: {command.error_lines()}")
    status = command.finish(out.name, "--shard", f"{lost}/{SHARDS}", "--resume")
    require(status == 0, f"exit status {status} of --resume: {command.error_lines()}")
    merged = command.work / "merged"
    shutil.rmtree(merged, ignore_errors=True)
    inputs = sorted(str(shard) for shard in (out / "shards").iterdir())
    merge = subprocess.run([command.arguments[0], "merge", *inputs, "--out", str(merged)], capture_output=True, text=True)
    require(merge.returncode == 0, f"merge: {merge.stderr}")
    require(rows(merged) == rows(whole), "other rows in the merged store")
    for name in files(merged) - NOT_COMPARED:
        if name.endswith(".csv"):
            require(filecmp.cmp(merged / name, whole / name, shallow=False), f"{name} differs")
    return f"shard {lost} of {SHARDS} lost after {moment_s:.2f} s"


class SharedFolder:
    """The variables that let a command see the folder `out` through slow_folder.cpp."""

    def __init__(self, work, out):
        self.state = work / "slow_folder.state"
        self.variables = {"LD_PRELOAD": os.environ["PICKBED_SLOW_FOLDER"], "SLOW_FOLDER": str(out),
                          "SLOW_FOLDER_STATE": str(self.state)}

    def with_fault(self, **numbers):
        """The variables of a fault. Counting begins anew."""
        self.state.write_bytes(bytes(8))
        return {**self.variables, **{f"SLOW_FOLDER_{name.upper()}": str(value) for name, value in numbers.items()}}

    def calls(self):
        return int.from_bytes(self.state.read_bytes(), sys.byteorder)


def slow_case(command, whole, out, rng):
    """All calls take time, and new files of other processes are seen late. The command ends as otherwise."""
    folder = SharedFolder(command.work, out)
    delay_us, late_us = rng.randrange(100, 20000), rng.randrange(0, 2000000)
    variables = folder.with_fault(delay_us=delay_us, late_us=late_us)
    status = command.finish(out.name, variables=variables)
    require(status == 0, f"exit status {status}: {command.error_lines()}")
    require(folder.calls() > 0, "the folder was not slow")
    require_same(out, whole)
    return f"{folder.calls()} calls of up to {delay_us} us, files late by {late_us} us"


def failing_call_case(command, whole, out, number, rng, calls):
    """One call in the folder, or each later one that writes, fails. The command is repeated with --resume."""
    folder = SharedFolder(command.work, out)
    if command.kind not in calls:
        status = command.finish(out.name, variables=folder.with_fault())
        require(status == 0, f"exit status {status} without a fault: {command.error_lines()}")
        calls[command.kind] = folder.calls()
        shutil.rmtree(out)
    fail_at = rng.randrange(1, calls[command.kind] + 1)
    fault = {"read_only_from": fail_at} if number == errno.EROFS else {"fail_at": fail_at, "errno": number}
    status = command.finish(out.name, variables=folder.with_fault(**fault))
    lines = command.error_lines()
    what = f"call {fail_at} of {calls[command.kind]}" + ("" if folder.calls() >= fail_at else ", which was not made")
    require(status in (0, BAD_INPUT), f"{what}: exit status {status}: {lines}")
    require(len(lines) <= 1, f"{what}: more than one line: {lines}")
    require(status == 0 or out.name in lines[0], f"{what}: no line with the folder: {lines}")
    before = rows(out, with_times=True)
    status = command.finish(out.name, "--resume")
    require(status == 0, f"{what}: exit status {status} of --resume: {command.error_lines()}")
    require_kept(before, out)
    require_same(out, whole)
    return f"{what}, {lines[0] if lines else 'no error'}"


def mounts_of_our_own():
    """Starts this program again where it may mount, if it is not there."""
    if os.environ.get("PICKBED_FAULTS_MOUNT") == "yes":
        return
    unshare = ["unshare", "--mount"] + ([] if os.geteuid() == 0 else ["--map-root-user"])
    probe = subprocess.run([*unshare, "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True, text=True)
    if probe.returncode != 0:
        print(f"skipped: this machine permits no mount: {probe.stderr.strip()}", file=sys.stderr)
        sys.exit(SKIPPED)
    os.environ["PICKBED_FAULTS_MOUNT"] = "yes"
    os.execvp(unshare[0], [*unshare, sys.executable, *sys.argv])


def main():
    pickbed, fault, cases, seed = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    if fault == "full_disk":
        mounts_of_our_own()
    if fault in CLOCKS and shutil.which("faketime") is None:
        print("skipped: there is no faketime; see group test in packages.txt", file=sys.stderr)
        return SKIPPED
    if fault in ("slow_folder", *FAILING_CALLS) and "PICKBED_SLOW_FOLDER" not in os.environ:
        print("skipped: PICKBED_SLOW_FOLDER does not name the library slow_folder", file=sys.stderr)
        return SKIPPED
    failures = 0
    met = 0  # cases in which the fault met a working command, of faults that can miss it
    calls = {}  # of an undisturbed command in the shared folder
    with tempfile.TemporaryDirectory(prefix="pickbed_faults_") as name:
        work = pathlib.Path(name)
        (work / "small.yaml").write_text(SCENARIO)
        (work / "sweep.yaml").write_text(SWEEP)
        undisturbed = {}
        for kind in ("run", "sweep"):
            command = Command(os.path.abspath(pickbed), kind, work)
            start = time.monotonic()
            require(command.finish(f"whole_{kind}") == 0, f"the undisturbed {kind} fails")
            duration_s = time.monotonic() - start
            whole = work / f"whole_{kind}"
            size = sum((whole / file).stat().st_size for file in files(whole))
            undisturbed[kind] = command, whole, duration_s, size
        for case in range(cases):
            rng = random.Random(f"{seed} {fault} {case}")
            command, whole, duration_s, size = undisturbed["run" if case % 2 == 0 and fault != "lost_node" else "sweep"]
            out = work / "out"
            shutil.rmtree(out, ignore_errors=True)
            try:
                if fault == "full_disk":
                    what = disk_case(command, whole, out, size, rng)
                elif fault == "memory_limit":
                    has_met, what = memory_case(command, whole, out, duration_s, rng)
                    met += has_met
                elif fault == "two_writers":
                    has_met, what = two_writers_case(command, whole, out, duration_s, rng)
                    met += has_met
                elif fault == "lost_node":
                    what = lost_node_case(command, whole, out, duration_s, rng)
                elif fault == "slow_folder":
                    what = slow_case(command, whole, out, rng)
                elif fault in FAILING_CALLS:
                    what = failing_call_case(command, whole, out, FAILING_CALLS[fault], rng, calls)
                else:
                    what = signal_case(command, fault, whole, out, duration_s, rng)
                print(f"{fault} {case}: {command.kind}, {what}: as undisturbed", flush=True)
            except Failed as failed:
                failures += 1
                print(f"{fault} {case}: {command.kind}: FAILED: {failed}", flush=True)
    if fault in ("memory_limit", "two_writers") and met == 0:
        failures += 1
        print(f"{fault}: FAILED: no case met a working command", flush=True)
    print(f"{fault}: {cases} cases, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
