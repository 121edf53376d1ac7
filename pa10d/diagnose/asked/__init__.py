"""What somebody asks for by name: an effect or a map, fitted in beside the model."""
