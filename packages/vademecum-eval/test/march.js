// What every place of the tests does with a body: on a page, in a worker and in Node the same numbers must come out, bit for bit.

/** All numbers of a march, as the hexadecimal digits of their bits. */
export async function march(Body, bytes) {
  const numbers = [];
  for (const precision of ["single", "double"]) {
    const body = await Body.open(bytes, { precision });
    const place = body.locate([1, 0.08, 0.1]);
    body.push(place, [3, -8, -20]);
    for (const name of body.patternNames) body.pushPattern(name, 0.5);
    for (let turn = 0; turn < 40; turn++) {
      if (turn === 20) body.clear();
      body.step(turn % 3 + 1);
      numbers.push(...body.probeNames.map((name) => body.probe(name)), ...body.point(place), ...body.point(place, "velocity"));
    }
    numbers.push(...body.surface(), ...body.surface("velocity"), ...body.save());
    for (const { name, count } of body.quantities) {
      for (let index = 0; name !== "point" && index < Math.min(count, 9); index++) numbers.push(...body.read(name, index));
    }
  }
  return Array.from(new BigUint64Array(new Float64Array(numbers).buffer), (bits) => bits.toString(16)).join(" ");
}
