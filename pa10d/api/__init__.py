"""The HTTP API: routes, schemas, problems, and who may call what."""
