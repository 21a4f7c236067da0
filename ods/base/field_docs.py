"""Meanings of the fields of a settings type: the strings below them in its source."""

import ast
import inspect
import textwrap
from itertools import pairwise

import msgspec

from ods.base.settings import Settings


def field_docs(kind: type) -> dict[str, str]:
    """Return the strings below each field, those of its bases among them; empty where there is no source."""
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    except (OSError, SyntaxError, TypeError):
        return {}
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    docs: dict[str, str] = {}
    for base in set(kind.__bases__) - {Settings, msgspec.Struct}:
        docs |= field_docs(base)
    for field, below in pairwise(body):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(below, ast.Expr):
            docs[field.target.id] = " ".join(ast.literal_eval(below.value).split())
    return docs
