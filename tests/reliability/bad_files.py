"""STEP files that are wrong, each in its own way: name to a function of a good box's text."""

import re


def _swap(pattern, new, count=1):
    return lambda text: re.sub(pattern, new, text, count=count)


def _dangling(text):
    return re.sub(r"(MANIFOLD_SOLID_BREP\('',)#\d+", r"\g<1>#999999", text)


def _cyclic(text):
    number = re.search(r"(#\d+) = MANIFOLD_SOLID_BREP", text)[1]
    return re.sub(r"(MANIFOLD_SOLID_BREP\('',)#\d+", rf"\g<1>{number}", text)


def _missing_face(text):
    return re.sub(r"(CLOSED_SHELL\('',\()#\d+,", r"\1", text)


def _no_solid(text):
    """A closed shell that no solid holds is made one; an open surface cannot be."""
    one_face = re.sub(r"(CLOSED_SHELL\('',\(#\d+),[^)]*\)", r"\1)", text)
    one_face = one_face.replace("CLOSED_SHELL", "OPEN_SHELL")
    return re.sub(r"MANIFOLD_SOLID_BREP\('',(#\d+)\)", r"SHELL_BASED_SURFACE_MODEL('',(\1))", one_face)


def _one_point(value):
    """One coordinate of a corner of the box."""
    return _swap(r"CARTESIAN_POINT\('',\(-1\.5,-1\.,-0\.5\)\)", f"CARTESIAN_POINT('',({value},-1.,-0.5))", 1)


TEXTS = {
    "empty": lambda text: "",
    "blank": lambda text: "\n\n",
    "not_step": lambda text: "This is a letter to a friend.\n" * 50,
    "html": lambda text: "<!DOCTYPE html><html><body>404 Not Found</body></html>",
    "header_only": lambda text: text.split("DATA;")[0] + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n",
    "truncated_10": lambda text: text[: len(text) // 10],
    "truncated_50": lambda text: text[: len(text) // 2],
    "truncated_90": lambda text: text[: len(text) * 9 // 10],
    "nan": _one_point("NaN"),
    "huge": _one_point("1.E300"),
    "overflow": _one_point("1.E999"),
    "moved_corner": _one_point("25."),
    "dangling": _dangling,
    "cyclic": _cyclic,
    "missing_face": _missing_face,
    "no_solid": _no_solid,
    "zeros": lambda text: "\0" * 5000,
}

HARMLESS = {
    "bom": lambda text: "\ufeff" + text,
    "crlf": lambda text: text.replace("\n", "\r\n"),
    "trailing_junk": lambda text: text + "\n\n/* the end */\n",
}


def in_unit(text, unit):
    """The same numbers in another unit of length."""
    millimetre = "SI_UNIT(.MILLI.,.METRE.)"
    if unit == "metre":
        return text.replace(millimetre, "SI_UNIT($,.METRE.)")
    inch = (
        "#90001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#90002);\n"
        f"#90002 = ( LENGTH_UNIT() NAMED_UNIT(*) {millimetre} );\n"
        "#90003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
    )
    used = "( CONVERSION_BASED_UNIT('INCH',#90001) LENGTH_UNIT() NAMED_UNIT(#90003) )"
    text = re.sub(r"\( LENGTH_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(\.MILLI\.,\.METRE\.\) \)", used, text)
    return text.replace("DATA;\n", "DATA;\n" + inch, 1)
