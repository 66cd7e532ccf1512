"""Which devices there are, which qualify, and opening one."""
