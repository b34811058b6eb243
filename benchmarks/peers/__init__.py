"""One file per peer, written as a user of that library would write it, from its documentation."""
