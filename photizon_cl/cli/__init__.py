"""The command line: ``photizon VERB …``, one verb a file."""
