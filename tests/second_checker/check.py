#!/usr/bin/env python3
"""check.py FILE...: what certificate files prove, decided in exact rational arithmetic.

A second implementation of docs/certificates.md, which is the specification; it shares no code with crates/proof. Python
3.10 and its standard library are enough.

Prints `FILE: Proved`, or `FILE: Rejected: ` with the reason. A reason that begins with "not shown" says that this
checker found no proof; every other reason is a defect of the file, or a fact that is false. Exit status: 0 if every
file is proved, 1 if one is rejected, 2 if one cannot be read as JSON. `-` is the standard input.
"""

import sys
import time

import document
import intervals
import sampled
import super_twisting
import theorems
import words
from deployed import deployed_observer
from document import Field, Malformed, Unreadable
from kkl import kkl_error_bound
from rational import Refuted, NotShown

KINDS = (
    theorems.KINDS
    | sampled.KINDS
    | intervals.KINDS
    | super_twisting.KINDS
    | {"deployed-observer": deployed_observer, "kkl-error-bound": kkl_error_bound}
)
FORMAT, VERSION = "luenberger-certificate", 2


def check(data):
    """The statement that the bytes of a file prove."""
    tree = document.parse(data)
    with Field(tree, "the document").object() as file:
        file.path = ""
        file.take("format").word(FORMAT)
        version = file.take("version").count()
        if version != VERSION:
            raise Malformed(f"version {version} of the format; this checker knows version {VERSION}")
        file.take("title").name()
        stated = file.take("statement").text()
        statement, facts = KINDS[file.take("theorem").word(*KINDS)](file)
        claims = []
        for item in file.take("margins").items():
            with item.object() as claim:
                claims.append((claim.take("inequality").text(), claim.take("margin").number()))
        seal = file.take("sha256").text()
    if seal != document.digest(tree):
        raise Malformed(f"sha256: the digest of the content is {document.digest(tree)}")
    if stated != statement:
        raise Malformed(f'statement: the data say "{statement}"')
    if len(claims) != len(facts):
        raise Malformed(f"margins: the theorem has {len(facts)} inequalities")
    for (claimed, margin), (label, test) in zip(claims, facts):
        if claimed != label:
            raise Malformed(f'margins: the inequality in this place is "{label}"')
        if margin < 0:
            raise Refuted(f"{label}: a margin is not negative")
        try:
            test(margin)
        except (Refuted, NotShown) as why:
            raise type(why)(f"{label}: {why}") from None
    return statement


def outcome(data):
    """The exit status and what is printed."""
    try:
        check(data)
        return 0, "Proved"
    except Unreadable as why:
        return 2, f"Unreadable: {why}"
    except (Malformed, Refuted) as why:
        return 1, f"Rejected: {why}"
    except NotShown as why:
        return 1, f"Rejected: not shown: {why}"
    except ArithmeticError as why:
        return 1, f"Rejected: not shown: {why} (a number too large for a proposal in floating point)"


def read(path):
    with sys.stdin.buffer if path == "-" else open(path, "rb") as file:
        return file.read(document.LARGEST_FILE + 1)


def main(arguments):
    timed = arguments[:1] == ["--time"]
    files = arguments[timed:]
    if not files or any(name.startswith("-") and name != "-" for name in files):
        print(__doc__, file=sys.stderr)
        return 2
    worst = 0
    for path in files:
        start = time.perf_counter()
        try:
            status, text = outcome(read(path))
        except OSError as error:
            status, text = 2, f"Unreadable: {error}"
        took = f" ({time.perf_counter() - start:.3f} s)" if timed else ""
        print(f"{words.visible(path)}: {words.visible(text)}{took}", flush=True)
        worst = max(worst, status)
    return worst


if __name__ == "__main__":
    # Numbers have up to 20 000 digits; the length is checked before they are read.
    sys.set_int_max_str_digits(0) if hasattr(sys, "set_int_max_str_digits") else None
    sys.exit(main(sys.argv[1:]))
