"""What docs/security.md promises of the code: no network, no shell, no code from text, one way to start a process."""

import ast
from pathlib import Path

import pytest

ADDON = Path(__file__).resolve().parents[1] / "addon"
NETWORK = {"socket", "ssl", "http", "urllib.request", "ftplib", "smtplib", "imaplib", "xmlrpc", "asyncio", "requests", "urllib3", "aiohttp"}
CODE_FROM_TEXT = {"eval", "exec", "compile", "__import__"}
CODE_FROM_BYTES = {"marshal", "shelve", "dill", "cloudpickle"}
PROCESSES = {"subprocess.Popen", "subprocess.run", "subprocess.call", "subprocess.check_output", "os.fork", "os.execv", "os.spawnv"}
STARTS_PROCESSES = {"scene/child_python.py", "cli/batch/workers.py"}
READS_PICKLES = {"pipeline/remote/words.py"}


def sources():
    return {path.relative_to(ADDON).as_posix(): ast.parse(path.read_text(encoding="utf-8")) for path in sorted(ADDON.rglob("*.py"))}


def imported(tree):
    """The modules that a file imports, with what it takes from them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def called(tree):
    """The calls of a file: the dotted name, the call."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield ast.unparse(node.func), node


def forbidden(path, tree):
    """What a file must not do, where it does it."""
    for name in set(imported(tree)) & (NETWORK | CODE_FROM_BYTES):
        yield f"{path} imports {name}"
    for name, call in called(tree):
        is_bad = name in CODE_FROM_TEXT | {"os.system", "os.popen"} or any(word.arg == "shell" for word in call.keywords)
        is_bad |= name in ("pickle.loads", "pickle.load", "pickle.Unpickler") and path not in READS_PICKLES
        is_bad |= name in PROCESSES and path not in STARTS_PROCESSES
        if is_bad:
            yield f"{path}:{call.lineno} calls {name}"


def test_no_file_opens_a_connection_runs_text_or_starts_programs_of_its_own():
    assert not [fault for path, tree in sources().items() for fault in forbidden(path, tree)]


@pytest.mark.parametrize(
    "line",
    [
        "import socket",
        "from urllib.request import urlopen",
        "eval('1')",
        "run('x', shell=True)",
        "subprocess.run(['ls'])",
        "pickle.loads(b'')",
    ],
)
def test_such_a_line_would_be_found(line):
    assert list(forbidden("scene/records.py", ast.parse(line)))


@pytest.mark.parametrize("path", sorted(STARTS_PROCESSES))
def test_every_process_is_python_without_the_current_folder(path):
    text = (ADDON / path).read_text(encoding="utf-8")
    assert "sys.executable" in text and '"-P"' in text


def test_the_manifest_asks_for_files_alone():
    import tomllib

    manifest = tomllib.loads((ADDON.parent / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert set(manifest["permissions"]) == {"files"}
