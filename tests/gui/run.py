"""The host's side of `./dev gui-test`: the built zip in a real Blender window under Xvfb, driven by tour.py, its pictures in build/gui.

Builds the zip for Linux, installs it in a fresh home folder of the chroot as a user would, opens Blender with its window, waits for the
tour's result and judges it together with Blender's log. Exit codes: 0 every step passed, the log is clean, and Blender ended by itself;
1 something of that did not hold; 75 there is no windowed Blender here and none could be installed, so nothing was tested.
"""

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from faces import same_from_every_face

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"), "cad-shadow-preview", "gui")
SIZE = (1600, 1200)
LIMIT_S = {"tour": 1800, "stress": 3000, "held": 3000, "newcomer": 900}
# Blender alone may take minutes for the first drawing of a million triangles.
HANG_S = {"tour": 300, "stress": 600, "held": 600, "newcomer": 300}
PLANT_TRIANGLES = 100_000
ENDS_IN_S = 10  # on a machine with nothing else to do
SETUP_LIMIT_S, TIMED_OUT = 900, 124
NO_WINDOW_HERE = 75  # EX_TEMPFAIL: neither passed nor failed
MODULE = "bl_ext.user_default.cad_shadow_preview"
# What in Blender's log is a defect of ours.
BAD_LOG = re.compile(r"Traceback|Error:|EXCEPTION|Segmentation|Not freed|GL error|^WARN.*cad_shadow", re.MULTILINE)
PROVOKED = re.compile(r"^Error: broken\.glb holds no GLB data")  # what the tour's damaged file is answered with
# The splash would swallow the first click; the autosave would ask at the next start.
PREFERENCES = """
import bpy
preferences = bpy.context.preferences
preferences.view.show_splash = False
preferences.view.show_tooltips_python = False
preferences.filepaths.use_auto_save_temporary_files = False
bpy.ops.wm.save_userpref()
"""


class Chroot:
    """Commands inside the chroot, with a home folder of this run's own; paths given to them are the chroot's."""

    def __init__(self, root: Path, work: Path) -> None:
        self.root, self.work = root, work
        inside = "/" + work.relative_to(root).as_posix()
        self.environment = {
            "HOME": f"{inside}/home",
            "XDG_RUNTIME_DIR": f"{inside}/run",
            "TMPDIR": f"{inside}/run",
            "OUT": f"{inside}/out",
            "PATH": "/usr/bin:/bin:/usr/sbin:/sbin",
            "LANG": "C.UTF-8",
            "LP_NUM_THREADS": "2",
        }
        for name in ("home", "run", "out"):
            (work / name).mkdir(mode=0o700)

    def inside(self, path: Path) -> str:
        """A file of the work folder as the chroot names it."""
        return "/" + path.relative_to(self.root).as_posix()

    def start(self, command: list[str], **options: object) -> subprocess.Popen:
        """A process in the chroot."""
        return subprocess.Popen(["chroot", str(self.root), *command], env=self.environment, stdin=subprocess.DEVNULL, **options)

    def run(self, *command: str) -> None:
        """A process in the chroot that must succeed; its output is shown when it does not."""
        process = self.start(list(command), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        output, _ = process.communicate(timeout=600)
        if process.returncode:
            raise SystemExit(f"gui-test: {' '.join(command[:4])} failed\n{output}")


@contextmanager
def screen(chroot: Chroot, size: tuple[int, int]):
    """A virtual screen; the chroot's DISPLAY is set to it."""
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", f"{size[0]}x{size[1]}x24", "-nolisten", "tcp"]
    process = chroot.start(command, pass_fds=(writer,), stderr=subprocess.DEVNULL)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        chroot.environment["DISPLAY"] = ":" + pipe.readline().strip()
    try:
        yield
    finally:
        process.terminate()
        process.wait(10)


def build_package(folder: Path) -> Path:
    """The zip for Linux."""
    command = [sys.executable, "-m", "tools.build_package", "--platform", "linux-x64", "--output", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return next(folder.glob("*.zip"))


def install(chroot: Chroot, package: Path) -> None:
    """As a user does it, from the zip; then the preferences."""
    inside = chroot.work / package.name
    shutil.copy2(package, inside)
    chroot.run("blender", "--command", "extension", "install-file", "-r", "user_default", "-e", chroot.inside(inside))
    chroot.run("blender", "-b", "--python-exit-code", "3", "--python-expr", PREFERENCES)


def leave_uninstalled(chroot: Chroot, package: Path) -> None:
    """For the newcomer: the zip and a CAD file at hand, nothing installed, no preferences."""
    sys.path.insert(0, str(ROOT))
    from sample import write_plant

    shutil.copy2(package, chroot.work / "out")
    write_plant(chroot.work / "out" / "plant.glb", PLANT_TRIANGLES)


def load() -> float:
    """How many processes wait for each processor."""
    return os.getloadavg()[0] / len(os.sched_getaffinity(0))


def take_notes(process: subprocess.Popen, folder: Path) -> None:
    """Write the resident bytes of a process and the machine's load for each processor to files, again and again while it lives: the chroot
    has no /proc to look them up."""
    while process.poll() is None:
        with suppress(FileNotFoundError, ProcessLookupError):
            pages = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1])
            for name, value in (("memory", pages * os.sysconf("SC_PAGE_SIZE")), ("load", load())):
                (folder / f"{name}.new").write_text(str(value))
                (folder / f"{name}.new").replace(folder / name)
        time.sleep(0.5)


@dataclass(frozen=True)
class Ending:
    """How Blender ended: its exit code (None when it had to be ended), seconds from the last result to its end, and its log."""

    code: int | None
    seconds: float
    log: str


def drive(chroot: Chroot, script: str, steps: list[str], size: tuple[int, int]) -> Ending:
    """Blender with its window through tour.py or another of the scripts."""
    for path in HERE.glob("*.py"):
        shutil.copy2(path, chroot.work / path.name)
    log = chroot.work / "out" / "blender.log"
    chroot.environment |= {"HANG_S": str(HANG_S[script]), "STARTED": str(time.time())}
    command = [
        "blender",
        "--offline-mode",
        "--window-geometry",
        "0",
        "0",
        *map(str, size),
        "--no-window-focus",
        "--python",
        chroot.inside(chroot.work / f"{script}.py"),
        "--",
        *steps,
    ]
    with log.open("w") as file:
        process = chroot.start(command, stdout=file, stderr=subprocess.STDOUT)
        notes = threading.Thread(target=take_notes, args=(process, chroot.work / "out"), daemon=True)
        notes.start()
        try:
            code = process.wait(LIMIT_S[script])
        except subprocess.TimeoutExpired:
            code = None
        finally:
            ended = time.time()
            process.kill()
            process.wait()
        notes.join()
    result = chroot.work / "out" / "result.json"
    return Ending(code, ended - result.stat().st_mtime if result.is_file() else 0.0, log.read_text(errors="replace"))


def judge(results: list[dict], ending: Ending) -> int:
    """Print every step and what else was wrong; the exit code."""
    checks = [(step["name"], step["ok"], step["error"]) for step in results]
    checks.append(("Blender ended by itself", ending.code == 0, f"exit code {ending.code}"))
    most = ENDS_IN_S * max(load(), 1.0)
    checks.append((f"it ended within {ENDS_IN_S} s of being quit", ending.seconds < most, f"it took {ending.seconds:.0f} s"))
    bad = sorted({line.strip() for line in ending.log.splitlines() if BAD_LOG.search(line) and not PROVOKED.match(line.strip())})
    checks.append(("the log is clean", not bad, "\n".join(bad[:20]) + "\n(all of it in build/gui/blender.log)"))
    for name, ok, error in checks:
        print(f"{'passed' if ok else 'FAILED'}  {name}" + ("" if ok else f"\n{error}"))
    failed = sum(not ok for _, ok, _ in checks)
    print(f"{len(checks) - failed} passed, {failed} failed")
    return 1 if failed or not results else 0


def set_up(root: Path, suite: str) -> bool:
    """Have a windowed Blender in `root`, installed once; False, with the reason on the terminal, where that cannot be done."""
    code = subprocess.run(["timeout", "--kill-after=30", str(SETUP_LIMIT_S), HERE / "setup_root.sh", root, suite]).returncode
    if code:
        reason = f"it took longer than {SETUP_LIMIT_S} s" if code == TIMED_OUT else "see above"
        print(f"gui-test: LEFT OUT, nothing was tested: no windowed Blender could be set up here ({reason})", file=sys.stderr)
    return code == 0


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="./dev gui-test", description="The extension in a real Blender window.")
    parser.add_argument("steps", nargs="*", help="only these steps of the tour (default: all); or 'stress', 'held', 'newcomer'")
    parser.add_argument("--suite", default="trixie", choices=["trixie", "sid"], help="the Debian whose Blender is used (default: trixie)")
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), default=SIZE, help="the window's, default 1600x1200")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("gui-test: ended from outside"))  # so that Blender and the screen end, too
    root = CACHE / options.suite
    if not set_up(root, options.suite):
        return NO_WINDOW_HERE
    started, output = time.monotonic(), ROOT / "build" / "gui"
    with tempfile.TemporaryDirectory(prefix="gui-test-", dir=root) as folder:
        chroot = Chroot(root, Path(folder))
        named = options.steps[:1] and options.steps[0] in LIMIT_S
        script, steps = (options.steps[0], options.steps[1:]) if named else ("tour", options.steps)
        (leave_uninstalled if script == "newcomer" else install)(chroot, build_package(Path(folder, "home")))
        with screen(chroot, options.size):
            ending = drive(chroot, script, steps, options.size)
        folder = chroot.work / "out" / "faces"
        has_f12 = ending.code == 0 and (folder / "f12.exr").is_file()
        faces = same_from_every_face(chroot.run, folder, chroot.inside(folder)) if has_f12 else []
        shutil.rmtree(output, ignore_errors=True)
        shutil.copytree(chroot.work / "out", output)
    result = output / "result.json"
    found = json.loads(result.read_text()) if result.is_file() else {"steps": []}
    print(f"{found.get('blender', 'Blender')}, {found.get('gl', 'no window')}, {time.monotonic() - started:.0f} s, pictures in {output}")
    for title in ("numbers", "held_up_ms"):
        for name, value in found.get(title, {}).items():
            print(f"{title}: {name}: {json.dumps(value, indent=1) if title == 'held_up_ms' else value}")
    return judge(found["steps"] + faces, ending)


if __name__ == "__main__":
    sys.exit(main())
