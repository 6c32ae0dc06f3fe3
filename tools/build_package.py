"""Builds the extension's zips: fetches the locked wheels, lays out a clean copy of the sources, runs Blender's own builder on it.

Wheels are fetched with pip against the hashes of requirements/wheels.txt into build/wheels, once per state of that file. The builder and
the validator are those inside the `bpy` wheel of the interpreter that runs this. Not here: anything about what the extension does.
Source of the rules: Blender's manual, "Extensions", and `blender_ext.py build --help`.
"""

import argparse
import hashlib
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCK = ROOT / "requirements" / "wheels.txt"
PIP_PYTHON = ROOT / ".venv" / "boot" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")

# Blender 4.2-5.0 has Python 3.11, Blender 5.1 and 5.2 have 3.13; Debian builds its Blender 5.2 with 3.14.
PYTHONS = ("311", "313", "314")
# Blender's name of each platform → the wheel platforms that run there (glibc 2.28 and macOS 11 are Blender 4.2's own floors).
PLATFORMS = {
    "linux-x64": [f"manylinux_2_{minor}_x86_64" for minor in (28, 27, 24, 17)] + ["manylinux2014_x86_64"],
    "windows-x64": ["win_amd64"],
    "macos-arm64": ["macosx_11_0_arm64"],
}
PACKED = ("__init__.py", "addon", "licences", "LICENSE", "README.md", "CHANGELOG.md")
ONLY_FOR_BENCHMARKS = ("addon/pipeline/bare_passes.py", "addon/shaders/bare.vert", "addon/shaders/bare.frag")
MAX_ZIP_MB = 100


class BuildError(Exception):
    """What went wrong, with the tool's own words."""


def run(command: list, what: str) -> str:
    """The command's standard output; BuildError with all it said when it fails."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"{what} failed\n{done.stdout}{done.stderr}")
    return done.stdout


def fetch_wheels(platform: str, python: str) -> list[Path]:
    """The locked wheels for one platform and Python ("313"), downloaded at most once per state of the lock."""
    folder = ROOT / "build" / "wheels" / hashlib.sha256(LOCK.read_bytes()).hexdigest()[:12] / f"{platform}-{python}"
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=folder.parent))
        if not PIP_PYTHON.is_file():
            raise BuildError(f"{PIP_PYTHON} is missing: run this as ./dev package")
        tags = [part for tag in PLATFORMS[platform] for part in ("--platform", tag)]
        options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--require-hashes", "--only-binary=:all:"]
        target = ["--implementation", "cp", "--python-version", python, *tags, "-d", partial, "-r", LOCK]
        run([PIP_PYTHON, "-m", "pip", "download", *options, *target], f"fetching wheels for {platform}, Python {python}")
        if not folder.is_dir():  # another build may have been quicker
            partial.rename(folder)
    return sorted(folder.glob("*.whl"))


def copy_licences(wheels: dict[str, Path], folder: Path) -> None:
    """The licence file of every wheel, named after its distribution; one without any is an error."""
    for distribution, wheel in {name.split("-")[0]: path for name, path in wheels.items()}.items():
        with zipfile.ZipFile(wheel) as archive:
            names = [name for name in archive.namelist() if ".dist-info/licenses/" in name and not name.endswith("/")]
            if not names:
                raise BuildError(f"{wheel.name} carries no licence text")
            text = b"\n\n".join(archive.read(name) for name in sorted(names))
        (folder / f"{distribution}.txt").write_bytes(text)


def copy_sources(folder: Path) -> None:
    """A clean copy of the sources, without what only benchmarks need (the command `bench` says so)."""
    folder.mkdir(parents=True)
    for name in PACKED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__", ".*"))
        else:
            shutil.copy2(source, folder / name)
    for name in ONLY_FOR_BENCHMARKS:
        (folder / name).unlink()


def stage(folder: Path, platforms: list[str]) -> None:
    """A clean copy of what goes into the package, with its wheels and the manifest that lists them."""
    copy_sources(folder)
    (folder / "wheels").mkdir()
    wheels = {wheel.name: wheel for platform in platforms for python in PYTHONS for wheel in fetch_wheels(platform, python)}
    for name, wheel in wheels.items():
        shutil.copy2(wheel, folder / "wheels" / name)
    copy_licences(wheels, folder / "licences")
    folder.joinpath("blender_manifest.toml").write_text(manifest_text(platforms, sorted(wheels)), encoding="utf-8")


def manifest_text(platforms: list[str], wheels: list[str]) -> str:
    """The source manifest for these platforms, with the list of wheels before its first table."""
    text = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    known = tomllib.loads(text)["platforms"]
    if unknown := [platform for platform in platforms if platform not in known]:
        raise BuildError(f"blender_manifest.toml does not name {unknown}")
    quoted = ", ".join(f'"{platform}"' for platform in known)
    wanted = ", ".join(f'"{platform}"' for platform in platforms)
    listed = "".join(f'  "./wheels/{name}",\n' for name in wheels)
    head, table, tail = text.replace(f"platforms = [{quoted}]", f"platforms = [{wanted}]").partition("\n[")
    return f"{head}\nwheels = [\n{listed}]\n{table}{tail}"


def blender_tool() -> tuple[Path, Path]:
    """Blender's extension command and its list of valid tags, from the bpy wheel (bpy itself is not imported)."""
    found = importlib.util.find_spec("bpy")
    if found is None:
        raise BuildError("the bpy wheel is missing: run this as ./dev package")
    scripts = next(Path(found.origin).parent.glob("*/scripts"))
    return scripts / "addons_core/bl_pkg/cli/blender_ext.py", scripts / "modules/_bpy_internal/extensions/tags.py"


def build(output: Path, platforms: list[str]) -> list[Path]:
    """The validated zips in `output`, one per platform."""
    tool, tags = blender_tool()
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".package-", dir=output) as work:
        source, zips = Path(work, "source"), Path(work, "zips")
        stage(source, platforms)
        zips.mkdir()
        run([sys.executable, tool, "validate", "--valid-tags", tags, source], "validating the sources")
        command = [sys.executable, tool, "build", "--valid-tags", tags, "--source-dir", source, "--output-dir", zips, "--split-platforms"]
        run(command, "building")
        built = sorted(zips.glob("*.zip"))
        if len(built) != len(platforms):
            raise BuildError(f"{len(platforms)} zips expected, the builder made {[path.name for path in built]}")
        for path in built:
            run([sys.executable, tool, "validate", "--valid-tags", tags, path], f"validating {path.name}")
            check(path)
        return [path.replace(output / path.name) for path in built]


def check(path: Path) -> None:
    """What Blender's validator does not look at: the listed wheels are the ones inside, no numpy, no bytecode, not too large."""
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    listed = {name.removeprefix("./") for name in manifest["build"]["generated"]["wheels"]}  # what of the list is for this platform
    inside = {name for name in names if name.endswith(".whl")}
    if listed != inside:
        raise BuildError(f"{path.name}: listed and packed wheels differ: {sorted(listed ^ inside)}")
    if bad := [name for name in names if "numpy" in name or name.endswith((".pyc", ".so", ".dll"))]:
        raise BuildError(f"{path.name} must not carry {bad}")
    if path.stat().st_size > MAX_ZIP_MB * 1e6:
        raise BuildError(f"{path.name} is larger than {MAX_ZIP_MB} MB")


def main(argv: list[str] | None = None) -> int:
    """The command line: prints each zip with its size."""
    parser = argparse.ArgumentParser(prog="./dev package", description="Build and validate the extension's zips.")
    parser.add_argument("--platform", action="append", choices=list(PLATFORMS), help="only this platform (repeatable; default: all)")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "dist", help="folder for the zips (default: dist)")
    options = parser.parse_args(argv)
    try:
        built = build(options.output.resolve(), options.platform or list(PLATFORMS))
    except BuildError as error:
        print(f"package: {error}", file=sys.stderr)
        return 1
    for path in built:
        print(f"{path}  {path.stat().st_size / 1e6:.1f} MB, valid")
    return 0


if __name__ == "__main__":
    sys.exit(main())
