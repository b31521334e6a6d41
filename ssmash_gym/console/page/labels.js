/** Names and units of fields, from their keys and the descriptions of the schema. */
const UNITS = {
  m_s: "m/s", mps: "m/s", m_s2: "m/s\u00b2", mps2: "m/s\u00b2", kn: "kn", deg: "deg", rad: "rad", kN: "kN", kg: "kg", Pa: "Pa",
  hz: "Hz", s: "s", m: "m", m2: "m\u00b2", m3: "m\u00b3", g: "g", N: "N", kgm2: "kg m\u00b2", kgpm3: "kg/m\u00b3", Npm: "N/m",
  Npm2: "N/m\u00b2", Npm3: "N/m\u00b3", Nspm: "N s/m", Ns2pm2: "N s\u00b2/m\u00b2", Nmspr: "N m s/rad", Nmprad: "N m/rad",
  spr: "s/rad", spm: "s/m", ps: "1/s",
};
const WORDS = { cg: "c.g.", gm: "metacentric height", hs: "Significant wave height", tp: "Peak period", rms: "RMS" };
const TITLES = { lateral_g: "Lateral specific force", dof: "Degree of freedom", gm_m: "Metacentric height", kg_m: "Height of G" };
const KINDS = {
  fixed: "deck at rest", sinusoid: "one sine", irregular: "irregular motion", file: "recorded motion", seaway: "ship in a seaway",
  free: "given by itself", sea: "belongs to the sea", gas_oleo: "gas oleo", linear_strut: "linear strut",
};

/** Unit that a key ends in, or that its description has in brackets at the end. */
export function unitOf(key, description = "") {
  const parts = key.split("_");
  for (const count of [2, 1]) {
    const ending = parts.slice(-count).join("_");
    if (parts.length > count && ending in UNITS) return UNITS[ending];
  }
  const bracket = /\[([^\]]{1,14})\]\s*(;|$)/.exec(description);
  return bracket && bracket[1] !== "1" ? bracket[1] : "";
}

/** A key as a title: without its unit, with spaces. */
export function titleOf(key) {
  if (key in TITLES) return TITLES[key];
  let parts = key.split("_");
  for (const count of [2, 1]) {
    if (parts.length > count && parts.slice(-count).join("_") in UNITS) {
      parts = parts.slice(0, -count);
      break;
    }
  }
  const text = parts.map((part) => WORDS[part] ?? part).join(" ");
  return text[0].toUpperCase() + text.slice(1);
}

/** A description without the unit at its end, which stands at the field. */
export const plainOf = (description = "") =>
  description.replaceAll("`", "").replace(/\s*\[[^\]]{1,14}\](?=\s*(;|$))/, "").trim();

/** What a kind of a union or a choice is called. */
export const kindOf = (name) => KINDS[name] ?? String(name).replaceAll("_", " ");
