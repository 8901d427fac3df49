"""A client of the air picture; it needs nothing but Python 3.11 or later. `models` has the types of what is answered."""

import json
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Iterator
from http.client import HTTPException, HTTPResponse
from typing import Any, cast

from .models import FeatureOfTrackProperties as Track
from .models import Problem, StreamMessage

__all__ = ["ApiError", "Client", "Problem", "StreamMessage", "Track"]

# Shortest and longest time before a lost connection is tried again, seconds.
AGAIN_S = (0.5, 15.0)
# A stream has a heartbeat each second. It is lost after this time without one, seconds.
SILENT_S = 10.0


class ApiError(Exception):
    """The service does not do what was asked; `problem` is what it says (RFC 9457)."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(f"{problem['status']} {problem['title']}: {problem['detail']}")
        self.problem = problem


class Client:
    """`url` is the service's, "http://127.0.0.1:8080"; `token` is needed where the service asks for one."""

    def __init__(self, url: str, token: str | None = None) -> None:
        self._url = url.rstrip("/")
        self._headers = {} if token is None else {"Authorization": f"Bearer {token}"}

    def get(self, path: str, **parameters: Any) -> Any:
        """What a path answers. What stands in braces in it is taken out of the parameters; a list is joined by commas."""
        with self._ask(path, parameters) as answer:
            return json.load(answer)

    def post(self, path: str, body: Any = None, **parameters: Any) -> Any:
        """Has something done; `body` is sent as JSON."""
        data = b"" if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"}
        with self._ask(path, parameters, headers, data) as answer:
            return json.load(answer)

    def tracks(self, limit: int = 1000, **parameters: Any) -> Iterator[Track]:
        """All tracks of the picture, `limit` at a time."""
        while True:
            page = self.get("/api/v1/tracks", limit=limit, **parameters)
            yield from page["features"]
            if "next" not in page:
                return
            parameters["after"] = page["next"]

    def events(self, last_event_id: str | None = None, **parameters: Any) -> Iterator[StreamMessage]:
        """The events of the stream, one by one.

        A connection that is lost is made anew, and goes on behind the last event where the service remembers it; else there
        is a snapshot.
        """
        wait_s = AGAIN_S[0]
        while True:
            headers = {} if last_event_id is None else {"Last-Event-ID": last_event_id}
            try:
                with self._ask("/api/v1/stream", parameters, headers) as answer:
                    for event in _parsed(answer):
                        wait_s = AGAIN_S[0]
                        last_event_id = event["id"]
                        yield event
            except ApiError as error:
                if error.problem["status"] not in (429, 502, 503, 504):
                    raise
            except (OSError, HTTPException):
                pass
            time.sleep(wait_s)
            wait_s = min(2 * wait_s, AGAIN_S[1])

    def pictures(self, **parameters: Any) -> Iterator[dict[str, Track]]:
        """The tracks by id, whenever one has changed: the same dictionary each time."""
        tracks: dict[str, Track] = {}
        for event in self.events(**parameters):
            if event["event"] == "snapshot" or event["event"] == "resync":
                tracks.clear()
            if event["event"] == "snapshot" or event["event"] == "tracks":
                tracks.update((track["id"], track) for track in event["data"]["features"])
            elif event["event"] == "ended":
                for ended in event["data"]["ids"]:
                    tracks.pop(ended, None)
            else:
                continue
            yield tracks

    def _ask(
        self, path: str, parameters: dict[str, Any], headers: dict[str, str] | None = None, data: bytes | None = None
    ) -> HTTPResponse:
        query = {}
        for name, value in parameters.items():
            text = ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
            if f"{{{name}}}" in path:
                path = path.replace(f"{{{name}}}", urllib.parse.quote(text, safe=""))
            elif value is not None:
                query[name] = text
        url = self._url + path + ("?" + urllib.parse.urlencode(query) if query else "")
        request = urllib.request.Request(url, data, {**self._headers, **(headers or {})})
        try:
            return cast(HTTPResponse, urllib.request.urlopen(request, timeout=SILENT_S))
        except urllib.error.HTTPError as error:
            problem: Problem = {"type": "about:blank", "title": error.reason, "status": error.code, "detail": path}
            try:
                problem = json.load(error)
            except ValueError:
                pass
            raise ApiError(problem) from None


def _parsed(answer: HTTPResponse) -> Iterator[StreamMessage]:
    """Server-Sent Events as this service writes them: three lines each, and an empty one."""
    fields: dict[str, str] = {}
    for line in answer:
        name, _, value = line.decode().rstrip("\n").partition(": ")
        if name:
            fields[name] = value
        else:
            event = {"event": fields["event"], "id": fields["id"], "data": json.loads(fields["data"])}
            yield cast(StreamMessage, event)
            fields = {}
