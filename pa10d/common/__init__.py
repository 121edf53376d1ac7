"""What every room needs and none owns: errors, words, strict JSON and YAML, processors."""
