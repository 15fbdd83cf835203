"""Files for other CAD programs and printers: STEP of assemblies and parts, STL of parts; all lengths in mm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from layflat.errors import OutputError
from layflat.files import whole_file
from layflat.solids.colours import MATERIAL_COLOURS
from layflat.solids.kernel import kernel
from layflat.solids.meshes import triangulate

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from layflat.solids.assembly import Assembly
    from layflat.solids.component import Component

FILE_DATE = "2000-01-01T00:00:00+00:00"  # in headers of STEP, so that equal assemblies give equal files
STL_DEVIATION = 0.05  # most that a triangle is off a curved face, mm
STL_ANGLE = 0.2  # most between neighbouring triangles of a curved face, rad
LENGTH_UNIT = 1e-3  # of the files, m


class _Node(NamedTuple):
    """Shape in a file with its name and its colour, and what it consists of."""

    shape: Any
    name: str = ""
    colour: str = ""
    children: tuple[_Node, ...] = ()


def write_assembly_step(assembly: Assembly, label: Callable[[Component], str], path: Path) -> Path:
    """Write an assembly as STEP, a named and coloured body a part in a group a joint, and return the path.

    Args:
        assembly: the assembly.
        label: function that returns the name of a component's parts.
        path: of the file.

    Raises:
        OutputError: the file can't be written.
    """
    groups: dict[str, list[_Node]] = {}
    for component, _, body in assembly.bodies():
        node = _Node(body, label(component), MATERIAL_COLOURS[component.material])
        groups.setdefault(component.joint, []).append(node)
    return _write_step(
        _group(assembly.machine.name, [_group(joint or "arm", row) for joint, row in groups.items()]), path
    )


def write_part_files(solid: Any, name: str, path: Path) -> list[Path]:
    """Write a part as STEP and as STL and return the paths.

    Args:
        solid: of the part, in its own frame.
        name: of the part in the file.
        path: of the STEP file; that of the STL has another ending.

    Raises:
        OutputError: a file can't be written.
    """
    stl = path.with_suffix(".stl")
    triangulate(solid, STL_DEVIATION, STL_ANGLE)
    writer = kernel().StlAPI.StlAPI_Writer()
    writer.ASCIIMode = False
    with whole_file(stl) as temporary:
        _check_written(writer.Write(solid, str(temporary)), stl)
    return [_write_step(_group(name, [_Node(solid)]), path), stl]


def _group(name: str, children: Sequence[_Node]) -> _Node:
    """Return nodes as one node."""
    builder, shape = kernel().TopoDS.TopoDS_Builder(), kernel().TopoDS.TopoDS_Compound()
    builder.MakeCompound(shape)
    for child in children:
        builder.Add(shape, child.shape)
    return _Node(shape, name, children=tuple(children))


def _write_step(root: _Node, path: Path) -> Path:
    k = kernel()
    text, done = k.TCollection.TCollection_HAsciiString, k.IFSelect.IFSelect_ReturnStatus.IFSelect_RetDone
    for printer in k.Message.Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(k.Message.Message_Gravity.Message_Fail)
    writer = k.STEPCAFControl.STEPCAFControl_Writer(k.XSControl.XSControl_WorkSession(), False)
    header = k.APIHeaderSection.APIHeaderSection_MakeHeader(0)
    header.Apply(writer.Writer().Model())
    header.SetName(text(root.name))
    header.SetTimeStamp(text(FILE_DATE))
    header.SetOriginatingSystem(text("layflat"))
    writer.Transfer(_document(root), k.STEPControl.STEPControl_StepModelType.STEPControl_AsIs)
    with whole_file(path) as temporary:
        _check_written(writer.Write(str(temporary)) == done, path)
    return path


def _document(root: _Node) -> Any:
    """Return a document of the kernel with the names and colours of a tree."""
    k = kernel()
    text, doc = k.TCollection.TCollection_ExtendedString, k.XCAFDoc
    document = k.TDocStd.TDocStd_Document(text("XmlOcaf"))
    application = k.XCAFApp.XCAFApp_Application.GetApplication_s()
    application.NewDocument(text("MDTV-XCAF"), document)
    application.InitDocument(document)
    doc.XCAFDoc_DocumentTool.SetLengthUnit_s(document, LENGTH_UNIT)
    shapes = doc.XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colours = doc.XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def add(node: _Node, parent: Any | None) -> None:
        label = shapes.AddShape(node.shape, False) if parent is None else shapes.AddComponent(parent, node.shape)
        shape = label
        if shapes.IsReference_s(label):
            shape = k.TDF.TDF_Label()
            shapes.GetReferredShape_s(label, shape)
        for one in (label, shape):
            if node.name:
                k.TDataStd.TDataStd_Name.Set_s(one, text(node.name))
            if node.colour:
                colours.SetColor(one, _colour(node.colour), doc.XCAFDoc_ColorType.XCAFDoc_ColorGen)
        for child in node.children:
            add(child, shape)

    add(root, None)
    shapes.UpdateAssemblies()
    return document


def _colour(code: str) -> Any:
    """Return the kernel's colour of a code such as "#1b4682"."""
    k = kernel().Quantity
    red, green, blue = (int(code[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return k.Quantity_ColorRGBA(k.Quantity_Color(red, green, blue, k.Quantity_TypeOfColor.Quantity_TOC_sRGB), 1.0)


def _check_written(done: bool, path: Path) -> None:
    """Raise OutputError unless the kernel says that it wrote a file: it raises nothing where the disk is full."""
    if not done:
        raise OutputError("can't be written", where=str(path), right="see whether the disk is full")
