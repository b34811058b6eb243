"""Files that come from anywhere, and files that are written whole or not at all.

Lives here: `archives` (zip and npz of bounded size), `value_file` (nested values in one npz file), `writing`.
May not: know what is in them.
"""
