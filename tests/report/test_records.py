"""Records of files: their schemas are schemas, and refuse what is no such file."""

import jsonschema
import pytest

from oed.report.json_file import plain_value
from oed.report.provenance import Provenance
from oed.report.records.files import RECORDS, schemas
from oed.report.study_files import DEMO

SCHEMAS = schemas()


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_is_one(name: str) -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMAS[name])


def test_every_file_has_a_schema_of_its_own() -> None:
    records = [record for files in RECORDS.values() for record in files.values()]
    assert len(SCHEMAS) == len(set(records))


def test_a_file_with_an_unknown_or_a_wrong_field_is_refused() -> None:
    record = plain_value(Provenance.collect(DEMO, seed=None))
    assert isinstance(record, dict)
    schema = SCHEMAS["provenance.schema.json"]
    jsonschema.validate(record, schema)
    for wrong in ({**record, "more": 1}, {**record, "seed": "one"}, {"seed": 1}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema)
