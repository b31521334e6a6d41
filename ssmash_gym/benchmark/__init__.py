"""`ssmash benchmark`: recorded trials beside policies and agents in the same seas, with matched delays."""
