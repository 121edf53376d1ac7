"""Files before they are runs: what their columns are, what to know of them, then the import."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from starlette.requests import HTTPConnection

from pa10d.api.deps import MayReplace, TheDaemon
from pa10d.api.held import HeldFile, HeldFiles
from pa10d.api.problems import responses
from pa10d.api.routes.runs import refuse_taken_run
from pa10d.api.schemas.recordings import (
    ColumnChoices,
    FilePreview,
    ImportedEpisodes,
    ImportedRun,
    ImportEveryRequest,
    ImportRequest,
)
from pa10d.api.uploads import BODY, new_place, plain_name, take
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

router = APIRouter(prefix="/recordings", tags=["recordings"])


async def held_files(connection: HTTPConnection) -> HeldFiles:
    """The one collection of this application."""
    found: HeldFiles = connection.app.state.held
    return found


TheFiles = Annotated[HeldFiles, Depends(held_files)]


@router.post(
    "",
    response_model=FilePreview,
    status_code=201,
    responses=responses("refused", "too-large"),
    openapi_extra=BODY,
)
async def send_recording(
    daemon: TheDaemon,
    files: TheFiles,
    request: Request,
    filename: Annotated[str, Query(max_length=200)] = "recording.csv",
) -> JsonObject:
    """A file, to be looked at: its columns, first values, small curves, and what they seem to be.

    Nothing is stored; it waits for its import for an hour at most. What needs a fit (delay, signs)
    is not looked at yet: ask for the preview again with ``thorough``.
    """
    plain = plain_name(filename)
    place = await new_place(daemon)
    held = HeldFile(place, Path(place.name) / plain)
    try:
        await take(request, held.path, daemon)
        seen = await _preview(daemon, held, ColumnChoices(thorough=False))
    except BaseException:
        await held.clear()
        raise
    await files.keep(held)
    return seen


@router.post(
    "/{file}/preview",
    response_model=FilePreview,
    responses=responses("refused", "conflict", "not-found"),
)
async def preview_recording(
    daemon: TheDaemon, files: TheFiles, file: str, asked: ColumnChoices
) -> JsonObject:
    """The same file with other choices: what an import with them would make of it."""
    return await _preview(daemon, files.get(file), asked)


@router.post(
    "/{file}/import",
    response_model=ImportedRun,
    status_code=201,
    responses=responses("refused", "unsound", "conflict", "not-found"),
)
async def import_recording(
    daemon: TheDaemon, files: TheFiles, may_replace: MayReplace, file: str, asked: ImportRequest
) -> JsonObject:
    """It becomes a run; its mapping stays in the profile. What a fit must not use is refused unless
    forced, and the file waits on."""
    may_replace(asked.replace)
    async with files.taken(file) as held:
        way_out = "; or give replace: true"
        await refuse_taken_run(daemon, asked.name, way_out, replace=asked.replace)
        found = await daemon.answer(
            "import_file", file=str(held.path), profile=str(daemon.profile.path),
            mapping=asked.map, name=asked.name, replace=asked.replace, check=True,
            force=asked.force, part=asked.part.model_dump(),
        )  # fmt: skip
    daemon.events.publish("run", found["run"])
    return {**found["run"], "mapping_kept": found["kept"]}


@router.post(
    "/{file}/import-every",
    response_model=ImportedEpisodes,
    status_code=201,
    responses=responses("refused", "conflict", "not-found"),
)
async def import_every_episode(
    daemon: TheDaemon,
    files: TheFiles,
    may_replace: MayReplace,
    file: str,
    asked: ImportEveryRequest,
) -> JsonObject:
    """Every episode of a data set becomes a run, NAME-0 …; those that are refused are told, the
    others are stored all the same. Where none could be stored, the file waits on."""
    may_replace(asked.replace)
    runs: list[JsonObject] = []
    refused: list[JsonObject] = []
    async with files.taken(file) as held:
        for episode in await daemon.answer("episodes_of_file", file=str(held.path)):
            try:
                found = await daemon.answer(
                    "import_file", file=str(held.path), profile=str(daemon.profile.path),
                    mapping=asked.map, name=asked.name and f"{asked.name}-{episode}",
                    replace=asked.replace, check=True, force=asked.force,
                    part={"episode": episode},
                )  # fmt: skip
            except UserError as error:
                refused.append({"episode": episode, "detail": str(error)})
                continue
            daemon.events.publish("run", found["run"])
            runs.append({**found["run"], "mapping_kept": found["kept"]})
        if not runs:
            raise UserError(
                f"{held.path.name}: none of its {len(refused)} episodes can be imported; "
                f"{refused[0]['detail']}"
            )
    return {"runs": runs, "refused": refused}


@router.delete("/{file}", responses=responses("conflict", "not-found"))
async def drop_recording(files: TheFiles, file: str) -> dict[str, str]:
    """It is not wanted."""
    held = await files.let_go(file)
    return {"id": held.id, "file": held.path.name}


async def _preview(daemon: TheDaemon, held: HeldFile, asked: ColumnChoices) -> JsonObject:
    chosen = None if asked.columns is None else [one.model_dump() for one in asked.columns]
    found: JsonObject = await daemon.answer(
        "preview_file", file=str(held.path), profile=str(daemon.profile.path), choices=chosen,
        thorough=asked.thorough, part=asked.part.model_dump(),
    )  # fmt: skip
    return {"id": held.id, **found}
