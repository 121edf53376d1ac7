"""Where does a model fail, which effect is missing, what changed, and what would settle a doubt."""
