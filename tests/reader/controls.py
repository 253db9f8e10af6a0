"""What must be noticed: `controls.py TRAJECTORIES`. A comparison that nothing could fail would prove nothing.

In files of the trajectories, one byte of one section is changed at a time. With the old checksum the file is
refused. With a corrected one it opens, and the comparison with the trajectories must fail.
"""

import json
import sys

import agree
import vademecum
import writer

# Golden file, and the sections on which its marches depend.
MAPS = {
    "fixed-f64.vdm": ["Eigenvalues", "BlockState", "BlockLoad", "PatternBasis", "PatternBlock", "Factors",
                      "SurfaceBasis", "ProbeRows", "InteriorBasis"],
    "parameters.vdm": ["BlockState", "BlockLoad", "AxisPoints", "Factors", "RegionStiffness", "RegionMass"],
    "exact-f64.vdm": ["Eigenvalues", "DampingRatios", "ContactResidual", "PairResidual", "ProbeResidual",
                      "PatternResidual", "PatternProbeResidual"],
    "dashpots.vdm": ["DampingRows"],
    "quadrangles.vdm": ["PairResidual"],
    "reactions.vdm": ["ReactionBasis", "ReactionLoads", "PatternReaction"],
    "stress.vdm": ["StressBasis", "StressResidual", "PatternStress", "ElasticConstants"],
    "anisotropic.vdm": ["Compliance"],
    "bent.vdm": ["StrainLinear", "StrainTail", "StrainQuadratic", "PatternBasis"],
    "swinging.vdm": ["StrainModes"],
    "canonical.vdm": ["CanonicalTerms", "CanonicalFactors", "ReducedStiffness"],
}


def unnoticed(cases, file):
    """Whether every march still agrees."""
    try:
        found = [(max(agree.differences(case, file).values()), case) for case in cases]
    except (agree.Disagreement, vademecum.Refused):
        return False
    return all(worst <= agree.bound_of(case["structure"], case["steps"]) for worst, case in found)


def main(path):
    with open(path, encoding="utf-8") as lines:
        cases = [json.loads(line) for line in lines if any(f'/{name}"' in line[:4096] for name in MAPS)]
    failed = 0
    for name, sections in MAPS.items():
        own = [case for case in cases if case["file"].endswith("golden/" + name)]
        file = vademecum.read(own[0]["file"])
        assert unnoticed(own, file), f"{name} as it is"
        for section in sections:
            raw = writer.damaged(file, section)
            mended = writer.encode(file, {section: raw}, {})
            kept = bytearray(file.data)
            offset = file.entries[section]["offset"]
            kept[offset : offset + len(raw)] = raw
            try:
                vademecum.File(bytes(kept))
                refusal = "none"
            except vademecum.Refused as refused:
                refusal = str(refused)
            silent = unnoticed(own, vademecum.File(mended))
            if silent or refusal != "SectionChecksum":
                how = "not noticed" if silent else "noticed"
                print(f"{name}, a byte of {section}: refusal {refusal}, and {how} with a corrected checksum")
                failed += 1
    print(f"controls: {sum(map(len, MAPS.values()))} changed bytes, {failed} not noticed")
    return failed == 0


if __name__ == "__main__":
    sys.exit(0 if main(sys.argv[1]) else 1)
