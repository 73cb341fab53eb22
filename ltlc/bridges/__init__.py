"""Ways into the libraries that agents come from; each module needs the library that it is named after.

Nothing here is imported unless it is asked for: `import ltlc.bridges.stable_baselines3`. Without the library that fails
with a `MissingProgramError`, which says how to install it. Examples: docs/libraries.md and examples/.
"""
