"""Load on a daemon: telemetry listeners and requests, as fast as asked. python bench_load.py URL"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import signal

import httpx
from websockets.asyncio.client import connect

PATHS = ("/api/v1/robot", "/api/v1/runs", "/api/v1/models", "/metrics", "/api/v1/effects")


async def listen(url: str) -> None:
    """One page's worth of live values."""
    address = f"ws{url.removeprefix('http')}/api/v1/telemetry?history=10"
    async with connect(address, proxy=None, max_size=1 << 24) as socket:
        async for _ in socket:
            pass


async def ask(url: str, rate: float) -> None:
    """Requests of all kinds in turn."""
    async with httpx.AsyncClient(base_url=url, trust_env=False, timeout=30) as http:
        while True:
            for path in PATHS:
                (await http.get(path)).raise_for_status()
                await asyncio.sleep(1.0 / rate)


async def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("--listeners", type=int, default=20)
    parser.add_argument("--rate", type=float, default=25.0, help="requests per second")
    given = parser.parse_args()
    tasks = [asyncio.create_task(listen(given.url)) for _ in range(given.listeners)]
    tasks.append(asyncio.create_task(ask(given.url, given.rate)))
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, lambda: [t.cancel() for t in tasks])
    with contextlib.suppress(asyncio.CancelledError):
        await asyncio.gather(*tasks)


if __name__ == "__main__":
    asyncio.run(main())
