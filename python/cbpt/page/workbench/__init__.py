"""The page live: the session and its files, who may come in, the server."""
