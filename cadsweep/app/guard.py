"""Who may ask the server for anything: who knows the token, under an address of this machine, from its own page.

Place in the flow: before every request, static files and the websocket included.

* The token is in the address that ``cadsweep open`` prints. The first answer to it sets a cookie of the same worth,
  which only this server's pages send (``SameSite=Strict``, not seen by scripts): scripts, styles and the websocket
  need no token in their addresses.
* The ``Host`` must be an address that the server was opened under: a name of somebody else's that is made to point here
  (DNS rebinding) is refused.
* An ``Origin`` other than the server's own is refused, and so is what a browser says comes from another site.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
ANYWHERE = frozenset({"0.0.0.0", "::", ""})
"""Hosts to listen on that mean every address of the machine."""

POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-eval' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' data:; worker-src 'self' blob:; "
    "object-src 'none'; base-uri 'self'; form-action 'none'; frame-ancestors 'self' http://localhost:* http://127.0.0.1:*"
)
"""Nothing is loaded from elsewhere; a picture is handed on as ``data:``. Vue makes functions of the page's template,
which takes 'unsafe-eval'; frames are those of notebooks on this machine."""


@dataclass(frozen=True, kw_only=True)
class Guard:
    """The rule for one server.

    Attributes
    ----------
    host : str
        What it listens on.
    token : str
        43 characters of the system's random source.
    """

    host: str = "127.0.0.1"
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)

    def refuses(
        self, *, host: str, token: str | None, cookie: str | None, origin: str | None, site: str | None
    ) -> tuple[int, str] | None:
        """Why a request is refused, as its status and a sentence; None where it is let in.

        Parameters
        ----------
        host : str
            The header ``Host``.
        token, cookie : str or None
            The one in the query, the one in the cookie.
        origin, site : str or None
            The headers ``Origin`` and ``Sec-Fetch-Site``.
        """
        if not self._is_ours(urlsplit(f"//{host}").hostname or ""):
            return 403, "This server does not go by that name."
        if origin is not None and urlsplit(origin).netloc != host:
            return 403, "This page may not ask here."
        if site == "cross-site" and token is None:
            return 403, "Another site may not ask here."
        if not any(given is not None and _same(given, self.token) for given in (token, cookie)):
            return 401, "The address has a token in it, which 'cadsweep open' printed: use the whole address."
        return None

    def _is_ours(self, name: str) -> bool:
        name = name.lower().rstrip(".")
        if name in LOOPBACK or name == self.host.lower():
            return True
        if self.host not in ANYWHERE:
            return False
        return _is_address(name) or name in {socket.gethostname().lower(), socket.getfqdn().lower()}


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(), token.encode())


def make_middleware(guard: Guard) -> Any:
    """The guard as aiohttp wants it, to be put before everything else."""
    from aiohttp import web

    @web.middleware
    async def guarded(request: Any, handler: Callable[[Any], Awaitable[Any]]) -> Any:
        # Cookies of one machine are sent to all its ports: each server's has a name of its own.
        cookie_name = f"cadsweep-{request.url.port}"
        token = request.query.get("token")
        refused = guard.refuses(
            host=request.headers.get("Host", ""),
            token=token,
            cookie=request.cookies.get(cookie_name),
            origin=request.headers.get("Origin"),
            site=request.headers.get("Sec-Fetch-Site"),
        )
        if refused is not None:
            return _hardened(web.Response(status=refused[0], text=refused[1]))
        try:
            response = await handler(request)
        except web.HTTPException as answer:  # a redirection is one, and so is what is not there
            response = answer
        if not response.prepared:
            if token is not None:
                response.set_cookie(cookie_name, guard.token, httponly=True, samesite="Strict", path="/")
            _hardened(response)
        if isinstance(response, web.HTTPException):
            raise response
        return response

    return guarded


def _hardened(response: Any) -> Any:
    response.headers["Content-Security-Policy"] = POLICY
    response.headers["X-Content-Type-Options"] = "nosniff"
    response.headers["Referrer-Policy"] = "no-referrer"
    response.headers["Cross-Origin-Resource-Policy"] = "same-origin"
    response.headers.setdefault("Cache-Control", "no-cache")
    return response
