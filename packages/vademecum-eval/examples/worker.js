// Steps a body in a worker. In: { bytes, push: { at, force }, steps }. Out: how far that place has moved.
import { Body } from "../index.js";

let body;
self.onmessage = async ({ data: { bytes, push, steps = 1 } }) => {
  if (bytes) body = await Body.open(bytes);
  body.clear();
  const place = push && body.locate(push.at);
  if (place) body.push(place, push.force);
  body.step(steps);
  // A copy, since the view is good until the next call only.
  const surface = body.surface().slice();
  self.postMessage({ moved: place && body.point(place), surface }, [surface.buffer]);
};
