"""What is said of wrong usage: value, place and remedy in one line, as of every other error.

The errors are click's, which typer brings in a copy of its own or takes from the package, by its version: so they are
known by what they hold.
"""

from __future__ import annotations

import difflib
import re
from typing import Any

import typer

from membrane_rs._messages import nearest, show

UsageError: Any = typer.BadParameter.__mro__[1]
"""The base of all errors of usage."""


def in_our_words(error: Any) -> str:
    """One line about an error of usage: what was written, where, and what to write."""
    context = error.ctx
    program = "membrane-rs" if context is None else context.command_path
    params = [] if context is None else context.command.get_params(context)
    if hasattr(error, "possibilities"):
        return _unknown_option(error.option_name, params, program)
    if hasattr(error, "option_name"):
        return _option_value(error, params, program)
    if hasattr(error, "param_type") and error.param is not None:
        return f"{_name(error.param)}: is missing; {_example(context) or see(program)}"
    words = str(error.message).rstrip(".")
    if isinstance(error, typer.BadParameter):
        name = error.param_hint if error.param is None else _name(error.param)
        sign = " =" if words[:1] in "'\"" and ": " in words else ":"
        return f"{name}{sign} {words}" if name else words
    return words


def unknown_command(name: str, known: list[str]) -> str:
    """Words about a command that is none."""
    return f"COMMAND = {show(name)}: no such command; {nearest(name, known)}"


def surplus(word: str, context: Any) -> str:
    """Words about an argument behind the last one that a command takes."""
    takes = [_name(param) for param in context.command.get_params(context) if param.param_type_name == "argument"]
    taken = f"takes {' '.join(takes)}" if takes else "takes none"
    return (
        f"{show(word)}: one argument too many; {context.command_path} {taken} and options; "
        "a value with a space needs quotes"
    )


def see(program: str) -> str:
    """The remedy where there is no better one."""
    return f"'{program} --help' lists what it takes"


def _unknown_option(option: str, params: list[Any], program: str) -> str:
    """Words about an option that is none."""
    names = [name for param in params if not param.hidden for name in (*param.opts, *param.secondary_opts)]
    key = option.lstrip("-")
    near = difflib.get_close_matches(option, [name for name in names if name.startswith("--")], n=1)
    if "." in key and "--set" in names:
        is_plain = re.fullmatch(r"[\w.-]+", key)
        remedy = f"a value of the scene is set by '--set {key}=VALUE'" if is_plain else see(program)
    elif near:
        remedy = f"did you mean '{near[0]}'?"
    else:
        remedy = see(program)
    return f"{show(option)}: no such option of {program}; {remedy}"


def _option_value(error: Any, params: list[Any], program: str) -> str:
    """Words about an option without its value, or a flag with one."""
    option = error.option_name
    found = next((param for param in params if option in (*param.opts, *param.secondary_opts)), None)
    if found is None:
        return f"{show(option)}: {str(error.message).rstrip('.')}; {see(program)}"
    if getattr(found, "is_flag", False):
        return f"{option}: takes no value; write it alone"
    said = str(found.help).replace("\\[", "[")  # brackets that are no markup of the help
    return f"{option}: needs a value: {said}"


def _name(param: Any) -> str:
    """What an argument or an option is called in its help."""
    if param.param_type_name == "argument":
        return str(param.metavar or param.name.upper())
    return str(max(param.opts, key=len))


def _example(context: Any) -> str:
    """The last command of the example in the help of a command, in one line."""
    text = (getattr(context.command, "epilog", None) or "") if context is not None else ""
    lines = re.sub(r"\s*\\\n\s*", " ", text).splitlines()
    return f"such as: {lines[-1].removeprefix('Example: ')}" if lines else ""
