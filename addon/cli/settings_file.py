"""What was chosen: the scene's settings, over them a settings file's, over them the command line's."""

from __future__ import annotations

import argparse
import tomllib
from pathlib import Path

from ..errors import SettingsError
from ..scene.user_files import read_bytes
from ..settings.combinations import idle, named
from ..settings.groups import Settings
from ..settings.looks import with_look
from ..settings.options import with_its_test, with_options
from ..settings.versions import migrated

MOST_SETTINGS = 1 << 20


def read_settings(path: str | None) -> dict[str, object]:
    """A settings file: options by name at the top, or tables named like the report's `settings`. Raises `SettingsError`."""
    if path is None:
        return {}
    try:
        content = migrated(tomllib.loads(read_bytes(Path(path), MOST_SETTINGS).decode()))
        overlaid(Settings(), content)
    except OSError as error:
        raise SettingsError(f"Settings file {path} cannot be read ({error.strerror}): check the path.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"Settings file {path} is not TOML: {error}.") from error
    except (TypeError, AttributeError) as error:
        raise SettingsError(f"Settings file {path} has a table or key that is not a setting: {error}.") from error
    return content


def overlaid(settings: Settings, content: dict[str, object]) -> Settings:
    """`settings` with the tables and then the options of a settings file put in place."""
    tables = {
        name: {key: tuple(v) if isinstance(v, list) else v for key, v in value.items()}
        for name, value in content.items()
        if isinstance(value, dict)
    }
    if "test" in tables:
        tables["test"] = with_its_test(tables["test"], "kind", settings)
    values = {name.replace("-", "_"): value for name, value in content.items() if not isinstance(value, dict)}
    return with_options(settings.replaced(**tables), values)


def chosen_settings(base: Settings, args: argparse.Namespace) -> Settings:
    """The scene's settings, over them the look's, the settings file's, the command line's. Raises `SettingsError`."""
    given = _options_of(args)
    if given.get("bias") is not None and "bias_strategy" not in given:
        given["bias_strategy"] = "constant"
    if isinstance(given.get("ground"), float):
        given["ground_height"], given["ground"] = given["ground"], "height"
    look = getattr(args, "look", None)
    settings = with_options(overlaid(with_look(base, look) if look else base, args.from_file), given)
    planes = getattr(args, "section", None)
    return settings.replaced(section={"planes": sum(planes, ())}) if planes else settings


def idle_options(settings: Settings, args: argparse.Namespace) -> tuple[str, ...]:
    """A line for each option of the settings file or the command line that changes nothing in `settings`."""
    return idle(dict.fromkeys((*named(args.from_file), *_options_of(args))), settings)


def _options_of(args: argparse.Namespace) -> dict[str, object]:
    return {name.removeprefix("option_"): value for name, value in vars(args).items() if name.startswith("option_")}
