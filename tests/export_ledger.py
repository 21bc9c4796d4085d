"""Write the ledger for other programs: ``python tests/export_ledger.py``.

It writes ``codecheck.yml`` and ``ro-crate-metadata.json`` at the top of the collection, from
``data/claims.csv`` and the evidence, as notebook 17 judges them. Run it after a change that
alters a verdict or its effect; a test compares.
"""

import json
from pathlib import Path

import yaml

from freeseg.studies import ledger, ledger_export

ROOT = Path(__file__).resolve().parent.parent


def exports(judged):
    """Text of each file, by its name."""
    codecheck = yaml.safe_dump(
        ledger_export.as_codecheck(judged),
        sort_keys=False,
        allow_unicode=True,
        width=100,
        explicit_start=True,
    )
    crate = json.dumps(ledger_export.as_ro_crate(judged), indent=1, ensure_ascii=False)
    return {"codecheck.yml": codecheck, "ro-crate-metadata.json": crate + "\n"}


if __name__ == "__main__":
    found = ledger.judge_claims(ledger.load_claims(), ledger.load_evidence())
    for name, text in exports(found).items():
        (ROOT / name).write_text(text, encoding="utf-8")
