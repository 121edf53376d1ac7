"""What a diagnosis says: objects, JSON, sentences, and what would settle a doubt."""
