"""Does an effect keep what a model, a search and a controller rely on? The conformance kit."""
