"""The effects that come with pa10d: one module, one class, one physical effect."""
