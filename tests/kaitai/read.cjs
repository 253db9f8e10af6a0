// Compiles formats/vademecum-1.ksy to JavaScript and prints what the generated parser reads of each file, as JSON: one object a file.
// node read.cjs MODULES KSY FILE…; MODULES is the folder that has kaitai-struct-compiler, kaitai-struct and yaml.
"use strict";
const fs = require("node:fs");
const [modules, description, ...files] = process.argv.slice(2);
const from = require("node:module").createRequire(modules + "/");
const KaitaiStream = from("kaitai-struct").KaitaiStream;

async function parser() {
  const compiler = from("kaitai-struct-compiler");
  const source = from("yaml").parse(fs.readFileSync(description, "utf8"));
  const output = await compiler.compile("javascript", source, null, false);
  const loaded = { exports: {} };
  const load = (name) => (name === "kaitai-struct/KaitaiStream" ? KaitaiStream : from(name));
  new Function("module", "exports", "require", "define", output["Vademecum1.js"])(loaded, loaded.exports, load, undefined);
  return loaded.exports.Vademecum1;
}

// Objects of the parser without its own bookkeeping; a number JSON cannot hold becomes its name. Bits, not decimals, for reals.
function bits(x) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, x);
  return view.getBigUint64(0).toString(16).padStart(16, "0");
}
const reals = (values) => values.map(bits);
const text = (t) => t.value;

function read(Vademecum, path) {
  const bytes = fs.readFileSync(path);
  const file = new Vademecum(new KaitaiStream(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length)));
  const h = file.header, m = file.metadata;
  const isReal = (e) => [Vademecum.Element.F32, Vademecum.Element.F64, Vademecum.Element.I16].includes(e.element);
  // Quantised: number (i, c) is its integer times scale (i / 128, c).
  const values = ({ element, shape, numbers }) => {
    if (element !== Vademecum.Element.I16) return numbers.values;
    const columns = shape[1] * shape[2];
    return numbers.integers.map((x, i) => x * numbers.scales[Math.floor(i / columns / 128) * columns + (i % columns)]);
  };
  const entry = (e) => ({
    kind: e.kind, element: e.element, codec: e.codec, required: e.required, shape: e.shape, offset: e.offset,
    stored_length: e.storedLength, decoded_length: e.decodedLength, crc32: e.crc32, stored_bytes: e.stored.length,
    values: e.numbers === undefined ? null : isReal(e) ? reals(values(e)) : e.numbers.values,
    blocks: e.blocks === undefined ? null : [e.blocks.blockLength, ...e.blocks.ends],
  });
  const stage = (s) => [
    ...reals([s.mass, s.damping, s.stiffness, s.time]), ...reals(s.load),
    ...reals(s.massHistory), ...reals(s.dampingHistory), ...reals(s.stiffnessHistory),
  ];
  return {
    header: { major: h.major, minor: h.minor, n_sections: h.nSections, file_length: h.fileLength },
    directory: file.directory.map(entry),
    metadata: {
      program: text(m.program), problem: text(m.problem), units: text(m.units), mesh_hash: Array.from(m.meshHash),
      counts: [m.nNodes, m.nSurfaceNodes, m.nLoadNodes, m.nTriangles, m.nLoadTriangles, m.nModes, m.nPatterns, m.nProbes],
      scheme_name: text(m.schemeName), n_stages: m.scheme.nStages, stages: m.scheme.stages.map(stage), finish: reals(m.scheme.finish),
      time: reals([m.timeStep, m.alpha, m.beta]), n_regions: m.nRegions, n_axes: m.nAxes, n_terms: m.nTerms,
      parameters: m.parameters.slice(0, m.nParameters).map((p) => ({
        name: text(p.name), unit: text(p.unit), role: p.role, region: p.region ?? null, log: p.log,
        range: reals([p.lower, p.upper, p.nominal]),
      })),
      axes: m.axes.slice(0, m.nAxes).map((a) => ({
        name: text(a.name), unit: text(a.unit), role: a.role, kind: a.kind, log: a.log, n_points: a.nPoints,
        exponents: a.monomial ? reals([a.monomial.theta, ...a.monomial.stiffness, ...a.monomial.density]) : null,
        range: reals([a.lower, a.upper]),
      })),
      structures: [m.diagonal, m.block], steps_are_nan: [m.certificateOfDiagonal.steps, m.certificateOfBlock.steps].map(Number.isNaN),
    },
  };
}

parser().then((Vademecum) => console.log(JSON.stringify(files.map((path) => read(Vademecum, path)))));
