// What a file may hold: a shape checks a value and throws one line with the place, what stands there and what must.

const shown = (value) => (value === undefined ? "missing" : (JSON.stringify(value) ?? "?").slice(0, 40));

function refuse(place, value, must) {
  throw new Error(`${place} = ${shown(value)}: must be ${must}`);
}

export const oneOf = (...choices) => (value, place) => choices.includes(value) || refuse(place, value, `one of ${choices.join(", ")}`);

export const flag = (value, place) => typeof value === "boolean" || refuse(place, value, "true or false");

export const text = (value, place) => (typeof value === "string" && value.length > 0 && value.length <= 100) || refuse(place, value, "a text of 1 to 100 characters");

export const anyText = (value, place) => (typeof value === "string" && value.length <= 100) || refuse(place, value, "a text of at most 100 characters");

export const within = (low, high) => (value, place) =>
  (typeof value === "number" && value >= low && value <= high) || refuse(place, value, `a number in ${low} .. ${high}`);

export const orNull = (shape) => (value, place) => value === null || shape(value, place);

export const list = (shape, least, most) => (value, place) => {
  if (!Array.isArray(value) || value.length < least || value.length > most) refuse(place, value, `a list of ${least} to ${most}`);
  value.forEach((each, i) => shape(each, `${place}[${i}]`));
};

export const record = (shapes) => (value, place) => {
  if (typeof value !== "object" || value === null || Array.isArray(value)) refuse(place, value, "an object");
  for (const key of Object.keys(value)) if (!Object.hasOwn(shapes, key)) throw new Error(`${place}.${key.slice(0, 40)}: is no key here; the keys are ${Object.keys(shapes).join(", ")}`);
  for (const [key, shape] of Object.entries(shapes)) shape(value[key], `${place}.${key}`);
};
