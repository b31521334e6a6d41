"""Safe operating windows: in which seas, from which direction and at which speed the limits are kept."""
