"""The errors a user can meet: one class per boundary, each message one line that says what to do."""


class UserError(Exception):
    """Something the user can mend; the message is one line and says how."""


class SettingsError(UserError, ValueError):
    """A setting outside its domain."""


class SceneError(UserError):
    """A scene that cannot be drawn (empty, no finite vertex, a camera that sees nothing)."""


class CadFileError(UserError):
    """A file that is missing, unreadable, of another type than its name says, or empty."""


class CadMemoryError(CadFileError):
    """A file that needs more memory than there is."""


class GpuError(UserError):
    """No OpenGL context, or a request beyond its limits."""


class DriverError(GpuError):
    """The graphics driver failed at what it can do otherwise: its context is made anew before anything else is drawn."""


class OutputError(UserError):
    """A result that cannot be written."""


class Cancelled(UserError):
    """The user pressed Esc; nothing is written."""
