"""Server to which Foxglove connects; it sends, and takes no commands but those of playback."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from layflat import extras
from layflat.errors import InputError

LOCAL_HOST = "127.0.0.1"  # reachable from this computer only
DEFAULT_PORT = 8765  # Foxglove's own default
MAX_QUEUED_MESSAGES = 8192  # messages that wait for a slow viewer; older ones are dropped


@dataclass
class ViewerListener:
    """Callbacks of the SDK's server, which calls them in threads of its own.

    The SDK reads no other attributes; those of its protocol that are missing do nothing.
    """

    subscribed: Callable[[str], None]  # called with the topic that a viewer subscribes to
    control: Callable[[Any], Any] | None = None  # returns the state of a playback after a viewer's request

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        """Pass on the topic of a new subscription."""
        self.subscribed(channel.topic)

    def on_unsubscribe(self, _client: Any, _channel: Any) -> None:
        """Ignore the end of a subscription."""

    def on_playback_control_request(self, request: Any) -> Any:
        """Pass on a request to play, pause, seek or change the speed."""
        return self.control(request) if self.control is not None else None


def start_server(
    context: Any,
    name: str,
    listener: ViewerListener,
    *,
    host: str,
    port: int,
    time_range: tuple[int, int] | None = None,
) -> Any:
    """Start a server for the topics of a context, and return it.

    Args:
        context: context of the SDK.
        name: name of the server, for people.
        listener: receiver of its callbacks.
        host: address by which viewers reach this computer.
        port: its port; 0: any free one.
        time_range: first and last stamp (ns) of what is played, under the control of viewers; None: it is live.

    Raises:
        InputError: the host is not this computer, or the port can't be had.
        MissingExtraError: the SDK is not installed.
    """
    sdk = extras.import_extra("foxglove", "foxglove")
    try:
        return sdk.start_server(
            name=name, host=host, port=port, context=context, server_listener=listener,
            capabilities=[sdk.Capability.Time], playback_time_range=time_range,
            message_backlog_size=MAX_QUEUED_MESSAGES,
        )  # fmt: skip
    except (RuntimeError, OverflowError) as error:
        reason = str(error).rpartition("bind port: ")[2].partition(" (os error")[0]
        if "use" in reason or "denied" in reason or isinstance(error, OverflowError):
            right = "give another, or 0 for any that is free"
            raise InputError(f"port {port} can't be had ({reason})", where="port", right=right) from None
        right = f"give an address of this computer, such as {LOCAL_HOST}"
        raise InputError(f"{host!r} can't be had ({reason})", where="host", right=right) from None
