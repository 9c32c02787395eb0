"""A script that outlives a killed caller: it ends the caller's worker and removes its temporary files.

Run as ``python -I -S guard.py CALLER PIDFILE``, and told on standard input what to remove: glob patterns,
each followed by a zero byte, in which ``{pid}`` stands for the worker's process id. A last word ``done``
says that the caller has tidied up itself. Where standard input ends without it, or
the caller's process is gone, the guard kills the worker's session (its process id stands in PIDFILE),
waits for its end and removes the paths.
"""

import os
import select
import signal
import sys
import time


def main() -> None:
    caller, pid_file = int(sys.argv[1]), sys.argv[2]
    text = b""
    while os.getppid() == caller:
        readable, _, _ = select.select([0], [], [], 0.5)
        if readable:
            more = os.read(0, 65536)
            if not more:
                break
            text += more
    patterns = os.fsdecode(text).split("\0")
    if "done" in patterns:
        return
    pid = worker_pid(pid_file)
    if pid is not None:
        kill_session(pid)
    import glob  # most guards are sent home, and need neither
    import shutil

    for path in (path for p in patterns if p for path in glob.glob(p.replace("{pid}", str(pid)))):
        if os.path.isdir(path) and not os.path.islink(path):
            shutil.rmtree(path, ignore_errors=True)
        elif os.path.lexists(path):
            os.unlink(path)


def worker_pid(pid_file: str) -> int | None:
    # A worker that is just starting writes its id first and then looks whether its caller is alive.
    for _ in range(20):
        try:
            with open(pid_file, encoding="ascii") as file:
                return int(file.read())
        except (OSError, ValueError):
            time.sleep(0.05)
    return None


def kill_session(pid: int) -> None:
    for _ in range(100):
        try:
            os.killpg(pid, signal.SIGKILL)
        except OSError:
            return
        if is_zombie(pid):
            return
        time.sleep(0.02)


def is_zombie(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return False


if __name__ == "__main__":
    for ignored in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(ignored, signal.SIG_IGN)
    main()
