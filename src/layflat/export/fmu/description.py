"""modelDescription.xml of an FMU, by FMI 2.0 or 3.0."""

from collections.abc import Iterator
from math import inf, isinf
from xml.etree import ElementTree as ET

from layflat._version import __version__
from layflat.export.fmu.model import MAX_SEED, FmuModel
from layflat.export.fmu.units import unit_exponents
from layflat.export.fmu.variables import Variable

DEFAULT_DURATION = 2.0  # of an experiment, s: that of a simulation run

SEED_PARAMETER = ("seed", "seed of the sensors' noise: its samples are those of a simulation run with this seed")
NOISE_PARAMETER = ("noise", "whether the sensors are noisy")


def model_description(model: FmuModel, version: str, identifier: str, title: str, token: str) -> bytes:
    """Return the content of modelDescription.xml.

    Args:
        model: the model.
        version: "2.0" or "3.0".
        identifier: name of the library, without suffix.
        title: description of the model.
        token: see `FmuModel.header`.
    """
    third = version == "3.0"
    root = ET.Element("fmiModelDescription", fmiVersion=version, modelName=identifier)
    root.set("instantiationToken" if third else "guid", token)
    root.set("description", title)
    root.set("generationTool", f"layflat {__version__}")
    root.set("variableNamingConvention", "structured")
    step = model.plant.cycle / model.plant.steps
    interface = {"modelIdentifier": identifier, "canHandleVariableCommunicationStepSize": "true"}
    if third:
        kept = {"canGetAndSetFMUState": "true", "canSerializeFMUState": "true", "fixedInternalStepSize": repr(step)}
        ET.SubElement(root, "CoSimulation", interface | kept)
    else:
        kept = {"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}
        own_memory = {"canNotUseMemoryManagementFunctions": "true"}
        ET.SubElement(root, "CoSimulation", interface | own_memory | kept)
    _add_units(root, [variable.unit for _, variable in model.variables])
    ET.SubElement(ET.SubElement(root, "LogCategories"), "Category", name="logStatusError")
    experiment = {"startTime": "0.0", "stopTime": repr(DEFAULT_DURATION), "stepSize": repr(model.plant.cycle)}
    ET.SubElement(root, "DefaultExperiment", experiment)
    (_add_third if third else _add_second)(root, model)
    ET.indent(root, " ")
    return bytes(ET.tostring(root, encoding="UTF-8", xml_declaration=True))


def _add_units(root: ET.Element, units: list[str]) -> None:
    definitions = ET.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(units):
        exponents = unit_exponents(unit)
        if exponents:
            base = {name: str(exponent) for name, exponent in exponents.items()}
            ET.SubElement(ET.SubElement(definitions, "Unit", name=unit), "BaseUnit", base)


def _attributes(reference: int, variable: Variable) -> dict[str, str]:
    """Return the attributes of a variable that both versions of FMI share."""
    attributes = {"name": variable.name, "valueReference": str(reference)}
    if variable.use in ("tunable", "fixed"):
        attributes |= {"causality": "parameter", "variability": variable.use}
    elif variable.use == "input":
        attributes["causality"] = "input"
    else:
        attributes |= {"causality": "output", "initial": "exact" if variable.held else "calculated"}
    undefined = unit_exponents(variable.unit) is None and variable.unit
    meaning = f"{variable.meaning}, {variable.unit}" if undefined else variable.meaning
    return attributes | ({"description": meaning} if meaning else {})


def _number_attributes(variable: Variable) -> dict[str, str]:
    """Return start and unit of a real variable."""
    attributes = {"unit": variable.unit} if unit_exponents(variable.unit) else {}
    if variable.use != "output" or variable.held:
        infinite = "INF" if variable.start == inf else "-INF"
        attributes["start"] = infinite if isinf(variable.start) else repr(variable.start)
    return attributes


def _noise_variables(model: FmuModel) -> Iterator[tuple[str, dict[str, str], dict[str, str]]]:
    """Yield the kind (that of FMI 3.0), attributes, and those of its type, of each parameter of the sensors' noise."""
    if model.has_plant:
        fixed = {"causality": "parameter", "variability": "fixed", "initial": "exact"}
        for place, kind, (name, meaning), typed in (
            (0, "Int32", SEED_PARAMETER, {"start": "0", "min": "0", "max": str(MAX_SEED)}),
            (1, "Boolean", NOISE_PARAMETER, {"start": "true"}),
        ):
            reference = str(model.size + place)
            yield kind, {"name": name, "valueReference": reference, "description": meaning} | fixed, typed


def _add_second(root: ET.Element, model: FmuModel) -> None:
    """Add variables and structure by FMI 2.0."""
    variables, outputs, initial = ET.SubElement(root, "ModelVariables"), list[int](), list[int]()
    for index, (reference, variable) in enumerate(model.variables, 1):
        scalar = ET.SubElement(variables, "ScalarVariable", _attributes(reference, variable))
        ET.SubElement(scalar, "Real", _number_attributes(variable))
        outputs += [index] if variable.use == "output" else []
        initial += [index] if variable.use == "output" and not variable.held else []
    for kind, attributes, typed in _noise_variables(model):
        scalar = ET.SubElement(variables, "ScalarVariable", attributes)
        ET.SubElement(scalar, "Integer" if kind == "Int32" else kind, typed)
    structure = ET.SubElement(root, "ModelStructure")
    _add_all(ET.SubElement(structure, "Outputs"), "Unknown", [{"index": str(i), "dependencies": ""} for i in outputs])
    if initial:
        _add_all(ET.SubElement(structure, "InitialUnknowns"), "Unknown", [{"index": str(i)} for i in initial])


def _add_third(root: ET.Element, model: FmuModel) -> None:
    """Add variables and structure by FMI 3.0."""
    variables, structure = ET.SubElement(root, "ModelVariables"), ET.SubElement(root, "ModelStructure")
    time = {"name": "time", "valueReference": str(model.size + 2), "causality": "independent"}
    ET.SubElement(variables, "Float64", time | {"variability": "continuous", "description": "time, s"})
    for reference, variable in model.variables:
        ET.SubElement(variables, "Float64", _attributes(reference, variable) | _number_attributes(variable))
    for kind, attributes, typed in _noise_variables(model):
        ET.SubElement(variables, kind, attributes | typed)
    outputs = [(reference, variable) for reference, variable in model.variables if variable.use == "output"]
    _add_all(structure, "Output", [{"valueReference": str(reference), "dependencies": ""} for reference, _ in outputs])
    initial = [{"valueReference": str(reference)} for reference, variable in outputs if not variable.held]
    _add_all(structure, "InitialUnknown", initial)


def _add_all(parent: ET.Element, tag: str, items: list[dict[str, str]]) -> None:
    for attributes in items:
        ET.SubElement(parent, tag, attributes)
