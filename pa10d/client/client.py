"""Everything that a daemon can be asked, call by call."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pa10d.client.connection import ApiError, Connection, JobFailed, problem_of
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.offline import passes

Progress = Callable[[float, str], None]

LOOK_EVERY = 0.25  # s between looks at a job
HOPELESS = 20.0  # s of one reason to be offline: the daemon has tried several times to connect
OVER = ("succeeded", "failed", "cancelled")


class Client(Connection):
    """Every call is one request, or one job that is waited for."""

    # -- robot ------------------------------------------------------------------------------

    def health(self) -> JsonObject:
        """``/healthz``."""
        return self._ask("GET", "/healthz")

    def robot(self) -> JsonObject:
        """The arm's state."""
        return self._ask("GET", "/api/v1/robot")

    def enable(self, recover: bool = False) -> JsonObject:
        """Power on and hold. recover: an arm that stands outside its position limits is brought
        back inside, slowly."""
        return self._ask("POST", "/api/v1/robot/enable", json={"recover": recover})

    def disable(self, anyway: bool = False) -> JsonObject:
        """Rest, brakes on, power off. anyway: also where a brake does not hold the arm."""
        return self._ask("POST", "/api/v1/robot/disable", json={"anyway": anyway})

    def stop(self, wait: float = 5.0) -> JsonObject:
        """Rest; waited for at most ``wait`` seconds."""
        return self._ask("POST", "/api/v1/robot/stop", params={"wait": wait})

    def reset(self) -> JsonObject:
        """Leave a fault."""
        return self._ask("POST", "/api/v1/robot/reset")

    def confirm(self) -> JsonObject:
        """Somebody has looked at the arm: every joint stands where it reads."""
        return self._ask("POST", "/api/v1/robot/confirm")

    def connect(self) -> JsonObject:
        """Try to reach the drives now, and whenever they are away."""
        return self._ask("POST", "/api/v1/robot/connect")

    def disconnect(self) -> JsonObject:
        """Leave the bus; the arm must be unpowered."""
        return self._ask("POST", "/api/v1/robot/disconnect")

    def drive_errors(self, *, clear: bool = False) -> list[JsonObject]:
        """What each drive remembers of its errors, newest first; clear: empty that."""
        if clear:
            return list(self._ask("POST", "/api/v1/robot/errors/clear")["drives"])
        return list(self._ask("GET", "/api/v1/robot/errors")["drives"])

    def let_others_command(self) -> None:
        """Give the command of the arm back, where it is ours."""
        with contextlib.suppress(UserError):
            self._ask("DELETE", "/api/v1/robot/lease")

    def use_controller(self, controller: str, model: str | None = None) -> JsonObject:
        """``pid``, or ``computed_torque`` or ``feed_forward`` with a model."""
        body = {"controller": controller, "model": model}
        return self._ask("PUT", "/api/v1/robot/controller", json=body)

    def wait_for_robot(self, *states: str, timeout: float = 30.0) -> JsonObject:
        """Until the arm is in one of the states; UserError with its reasons where it is not.

        A reason to be offline that stays the same over ``HOPELESS`` is not waited out.
        """
        until = time.monotonic() + timeout
        reason, since = None, time.monotonic()
        while True:
            robot = self.robot()
            if robot["state"] in states:
                return robot
            now = time.monotonic()
            if robot["offline_reason"] != reason:
                reason, since = robot["offline_reason"], now
            hopeless = now > since + HOPELESS and not passes(reason)
            if now > until or hopeless:
                why = reason or (robot["fault"] or {}).get("sentence", "")
                wanted = " or ".join(states)
                raise UserError(f"the arm is {robot['state']}, expected {wanted}; {why}")
            time.sleep(0.1)

    # -- profile ----------------------------------------------------------------------------

    def tuning(self) -> JsonObject:
        """Gains, limits and surroundings in force."""
        return self._ask("GET", "/api/v1/profile")

    def check_tuning(self, changes: Mapping[str, Any]) -> JsonObject:
        """What a change would do, by keys such as ``limits.velocity``: ``diff``, ``confirm``."""
        return self._ask("POST", "/api/v1/profile/check", json={"changes": dict(changes)})

    def tune(self, changes: Mapping[str, Any], confirmed: bool = False) -> JsonObject:
        """Write a change and go on with it; the arm must be unpowered, but for surroundings."""
        body = {"changes": dict(changes), "confirmed": confirmed}
        return self._ask("PATCH", "/api/v1/profile", json=body)

    def undo_tuning(self, confirmed: bool = False, check: bool = False) -> JsonObject:
        """Take the last change back; check: only say what that would do."""
        if check:
            return self._ask("POST", "/api/v1/profile/undo/check")
        return self._ask("POST", "/api/v1/profile/undo", json={"confirmed": confirmed})

    def tuning_versions(self) -> list[JsonObject]:
        """What was changed, newest first."""
        return list(self._ask("GET", "/api/v1/profile/versions")["items"])

    def responses(self, runs: Sequence[str], joint: int = 1) -> list[JsonObject]:
        """How a joint answered in each run: target, response, figures of its steps."""
        params = {"run": list(runs), "joint": joint}
        return list(self._ask("GET", "/api/v1/responses", params=params)["items"])

    # -- jobs -------------------------------------------------------------------------------

    def start(self, path: str, body: Any) -> JsonObject:
        """Start a job by POST; its document."""
        return self._ask("POST", f"/api/v1/{path}", json=body)

    def job(self, number: str) -> JsonObject:
        """One job, with its result."""
        return self._ask("GET", f"/api/v1/jobs/{number}")

    def cancel(self, number: str) -> JsonObject:
        """Ask a job to end."""
        return self._ask("POST", f"/api/v1/jobs/{number}/cancel")

    def wait(self, job: JsonObject, progress: Progress | None = None) -> JsonObject:
        """Until it is over; JobFailed unless it succeeded. Interrupted: the job is cancelled."""
        try:
            while True:
                job = self.job(job["id"])
                if progress is not None:
                    progress(job["progress"], job["message"])
                if job["status"] in OVER:
                    break
                time.sleep(LOOK_EVERY)
        except KeyboardInterrupt:
            said = f"job {job['id']} was cancelled"
            try:
                self.cancel(job["id"])
            except UserError as error:
                said = f"job {job['id']} could not be cancelled ({error})"
            raise KeyboardInterrupt(said) from None
        if job["status"] != "succeeded":
            raise JobFailed(job)
        return job

    # -- experiments ------------------------------------------------------------------------

    def experiment_kinds(self) -> list[JsonObject]:
        """Kinds with their JSON schemas."""
        return list(self._ask("GET", "/api/v1/experiments")["items"])

    def check_experiment(self, plan: Mapping[str, Any]) -> JsonObject:
        """The pre-check alone; nothing moves."""
        job = self.start("experiments/check", dict(plan))
        return dict(self.wait(job)["result"])

    def experiment(
        self,
        kind: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        *,
        plan: Mapping[str, Any] | None = None,
        progress: Progress | None = None,
        **options: Any,
    ) -> JsonObject:
        """Run one to its end → result: ``runs`` (ids), ``analysis``, ``recommendation``, …

        ``plan`` takes a diagnosis' ``next_experiment`` as it stands. options: name, tags,
        controller, model, replace, recover.
        """
        body = dict(plan) if plan is not None else {"kind": kind, "parameters": parameters or {}}
        job = self.start("experiments", {**body, **options})
        return dict(self.wait(job, progress)["result"])

    def starting_set(self) -> list[JsonObject]:
        """What to record first of an arm: experiments for ``series``."""
        return list(self._ask("GET", "/api/v1/experiments")["starting_set"])

    def series(
        self, experiments: Sequence[Mapping[str, Any]], progress: Progress | None = None
    ) -> JsonObject:
        """Several, one after the other → result: ``runs`` (ids), ``experiments``."""
        body = {"experiments": [dict(one) for one in experiments]}
        return self._result("experiments/series", body, progress)

    def track(
        self,
        models: Sequence[str],
        kind: str = "tracking",
        parameters: Mapping[str, Any] | None = None,
        progress: Progress | None = None,
        **options: Any,
    ) -> JsonObject:
        """One motion under PID, feed-forward and computed torque, the last two with each model →
        result: ``laws`` with tracking errors per joint (rad, m), ``worth``. options: name,
        replace."""
        body = {"models": list(models), "kind": kind, "parameters": parameters or {}, **options}
        return self._result("experiments/track", body, progress)

    # -- investigations -----------------------------------------------------------------------

    def prepare_investigation(self, progress: Progress | None = None, **asked: Any) -> JsonObject:
        """Plan one → its document with ``motions``; asked: name, minutes, since, fit, validate."""
        return self._result("investigations", asked, progress)

    def investigation(self, investigation: str) -> JsonObject:
        """How far it is."""
        return self._ask("GET", f"/api/v1/investigations/{investigation}")

    def investigate(
        self,
        investigation: str,
        progress: Progress | None = None,
        news: Callable[[JsonObject], None] = lambda state: None,
        recover: bool = False,
    ) -> JsonObject:
        """Carry one out, or go on with it, to its end or its pause. news: gets its document when
        it is looked at; recover: as ``enable`` has it, before each motion."""

        def told(share: float, message: str) -> None:
            news(self.investigation(investigation))
            if progress is not None:
                progress(share, message)

        return self._result(f"investigations/{investigation}/start", {"recover": recover}, told)

    # -- weighings ----------------------------------------------------------------------------

    def begin_weighing(self, weights: Sequence[str], name: str | None = None) -> JsonObject:
        """Plan one for the weights at hand, each ``MASS,X,Y,Z`` (kg, m); nothing moves."""
        return self._ask("POST", "/api/v1/weighings", json={"weights": [*weights], "name": name})

    def weighing(self, weighing: str) -> JsonObject:
        """How far it is, what is next, and what came of it."""
        return self._ask("GET", f"/api/v1/weighings/{weighing}")

    def weigh(self, weighing: str, weight: int, progress: Progress | None = None) -> JsonObject:
        """Record with a weight (its number, 0: none) → the weighing."""
        return self._result(f"weighings/{weighing}/record", {"weight": weight}, progress)

    def apply_weighing(self, weighing: str, joints: Sequence[int] = ()) -> JsonObject:
        """Write its gains into the profile."""
        body = {"joints": [*joints]}
        return self._ask("POST", f"/api/v1/weighings/{weighing}/apply", json=body)

    def undo_weighing(self, weighing: str) -> JsonObject:
        """The profile as it was before."""
        return self._ask("POST", f"/api/v1/weighings/{weighing}/undo")

    # -- runs -------------------------------------------------------------------------------

    def runs(self, **filters: Any) -> list[JsonObject]:
        """All runs, newest first; filters: name, profile, kind, tag, status."""
        return self._all("/api/v1/runs", filters)

    def run(self, run: str) -> JsonObject:
        """One run."""
        return self._ask("GET", f"/api/v1/runs/{run}")

    def upload(self, file: Path, name: str | None = None, **more: Any) -> JsonObject:
        """Bring in a CSV file."""
        query = {"filename": file.name, **({"name": name} if name else {}), **more}
        with file.open("rb") as body:
            return self._ask("POST", "/api/v1/runs", params=query, content=body)

    def export(self, run: str, form: str, out: Path) -> Path:
        """Write a run as csv, mcap, parquet or mat."""
        with self._http.stream("GET", f"/api/v1/runs/{run}/export", params={"format": form}) as got:
            if got.status_code >= 400:
                got.read()
                raise ApiError(problem_of(got))
            with out.open("wb") as file:
                for part in got.iter_bytes():
                    file.write(part)
        return out

    def delete_run(self, run: str) -> JsonObject:
        """Remove a run."""
        return self._ask("DELETE", f"/api/v1/runs/{run}")

    # -- models -----------------------------------------------------------------------------

    def models(self) -> list[JsonObject]:
        """All models, newest first."""
        return self._all("/api/v1/models", {})

    def model(self, model: str) -> JsonObject:
        """One model."""
        return self._ask("GET", f"/api/v1/models/{model}")

    def identify(
        self, runs: Sequence[str], name: str, progress: Progress | None = None, **more: Any
    ) -> JsonObject:
        """Textbook model from runs; the answer is that of ``pa10d identify``."""
        return self._result("models", {"runs": list(runs), "name": name, **more}, progress)

    def compare(
        self, model: str, runs: Sequence[str], progress: Progress | None = None, **more: Any
    ) -> JsonObject:
        """Error per joint and where the model fails."""
        return self._result("comparisons", {"model": model, "runs": list(runs), **more}, progress)

    def diagnose(
        self,
        model: str,
        fit: Sequence[str],
        validate: Sequence[str] = (),
        progress: Progress | None = None,
        **more: Any,
    ) -> JsonObject:
        """Which effect is missing. more: frozen, effect, joints."""
        body = {"model": model, "fit": list(fit), "validate": list(validate), **more}
        return self._result("diagnoses", body, progress)

    def sheet(self, diagnosis: str) -> JsonObject:
        """Plots and words of a diagnosis, by the id of its job."""
        return self._ask("GET", f"/api/v1/diagnoses/{diagnosis}/sheet")

    def add(
        self,
        model: str,
        effect: str,
        joints: Sequence[int],
        fit: Sequence[str],
        name: str,
        progress: Progress | None = None,
        **more: Any,
    ) -> JsonObject:
        """A new version with the effect fitted in."""
        body = {"effect": effect, "joints": list(joints), "fit": list(fit), "name": name, **more}
        return self._result(f"models/{model}/effects", body, progress)

    def improve(
        self, model: str, fit: Sequence[str], name: str, progress: Progress | None = None,
        **more: Any,
    ) -> JsonObject:  # fmt: skip
        """Diagnose and add until nothing significant is left. more: validate, experiments."""
        body = {"fit": list(fit), "name": name, **more}
        return self._result(f"models/{model}/improvements", body, progress)

    # -- live -------------------------------------------------------------------------------

    def events(self, since: int | None = None) -> Iterator[JsonObject]:
        """What happens, as it happens."""
        query = "" if since is None else f"?since={since}"
        with self._socket(f"/api/v1/events{query}") as socket:
            for message in socket:
                yield json.loads(message)

    def telemetry(self, history: float = 0.0) -> Iterator[tuple[list[str], float, Any]]:
        """(columns, start time s, rows (k, columns) float32) as they come."""
        import numpy as np

        with self._socket(f"/api/v1/telemetry?history={history:g}") as socket:
            columns = list(json.loads(socket.recv())["columns"])
            for packet in socket:
                start = float(np.frombuffer(packet, "<f8", 1)[0])
                rows = np.frombuffer(packet, "<f4", offset=8).reshape(-1, len(columns))
                yield columns, start, rows

    def _result(self, path: str, body: Any, progress: Progress | None) -> JsonObject:
        return dict(self.wait(self.start(path, body), progress)["result"])
