/**
 * The console's page: it puts link, input, gauges, traces, scene, roles, form and review together.
 *
 * For tests, stable names:
 *   ids       #scene #phase #clock #driver #viewers #banner #countdown #first #go #stick #knob #take #release #start #abort
 *             #again #next #hand-over #take-over #open-form #form #result #review #review-box #review-close #latency #late
 *   body      data-phase, data-mine ("yes" while this page holds the claw), data-by (person, policy, none),
 *             data-command-along / -across (last command sent), data-device, data-applied-along / -across (of the frame)
 *   form      #form-apply #form-save #form-undo #form-error, fields by data-path ("scenario.motion.hs_m")
 *   window.ssmash   read only: you, phase, driver, by, mine, viewers, mode, frame, command, used, late, steps, latency_ms,
 *             claw, fps, shown_step, paused, device, result, linked
 */
import { byId, number, show, write } from "./dom.js";
import { Form } from "./form.js";
import { Gauges } from "./gauges.js";
import { Input } from "./input.js";
import { Link } from "./link.js";
import { Outcome } from "./outcome.js";
import { Roles } from "./roles.js";
import { Traces } from "./traces.js";
import { View } from "./picture.js";

const SILENCE_MS = 1500; // without a frame while an episode runs
const LOOK_MS = 250; // between two looks at the link and the clock

const link = new Link();
const view = new View(byId("scene"), document.querySelector(".cameras"));
const gauges = new Gauges(byId("gauges"));
const traces = new Traces(byId("traces"));
const input = new Input(byId("stick"), byId("knob"), (command) => {
  if (!link.command(command, view.shownStep)) return;
  Object.assign(document.body.dataset, {
    commandAlong: String(command.along), commandAcross: String(command.across), device: command.device,
  });
});
const roles = new Roles(link, input);
const outcome = new Outcome(link, roles);
const form = new Form(byId("form"), link, roles);
const state = { setup: null, last: null, heard: 0 };

link.addEventListener("setup", ({ detail }) => {
  state.setup = detail;
  state.last = null;
  view.setup(detail.setup);
  gauges.setup(detail.setup);
  traces.setup(detail.setup);
  outcome.clear();
  const { scenario, helicopter, ship } = detail.names;
  const session = detail.session?.participant ? detail.session : null; // a free drive has none
  const parts = [scenario, helicopter, ship, `sea ${detail.seed}`];
  if (session) parts.unshift(`${session.participant}: ${session.phase} ${session.number}${session.of ? ` of ${session.of}` : ""}`);
  write(byId("names"), parts.filter(Boolean).join(" \u00b7 "));
  write(byId("versions"), `configuration ${detail.configuration}`);
});

link.addEventListener("frame", ({ detail }) => {
  const { frame } = detail;
  state.last = detail;
  state.heard = performance.now();
  view.push(frame);
  gauges.show(frame);
  traces.add(frame);
  roles.claw(detail.claw);
  write(byId("clock"), `${number(frame.t)} of ${number(state.setup?.setup.horizon_s, 0)} s`);
  write(byId("latency"), detail.latency_ms === null ? "\u2013" : `${number(detail.latency_ms, 0)} ms`);
  write(byId("late"), detail.steps ? `${detail.late} of ${detail.steps}` : "0");
  if (!roles.mine || roles.by === "policy") input.reflect(frame.command);
  document.body.dataset.appliedAlong = String(frame.command[0]);
  document.body.dataset.appliedAcross = String(frame.command[1]);
});

input.addEventListener("moved", () => {
  if (!form.open && !outcome.reviewing) roles.touched();
});

setInterval(() => {
  const silent = roles.phase === "running" && performance.now() - state.heard > SILENCE_MS;
  roles.look({ silent });
  write(byId("fps"), view.framesPerSecond ? `${number(view.framesPerSecond, 0)} per s` : "\u2013");
}, LOOK_MS);

byId("open-form").addEventListener("click", () => form.toggle());
byId("help").addEventListener("click", () => show(byId("first"), byId("first").hidden));

const reading = {
  you: () => roles.me, phase: () => roles.phase, driver: () => roles.driver, by: () => roles.by, mine: () => roles.mine,
  viewers: () => roles.viewers, mode: () => roles.mode, frame: () => state.last?.frame ?? null,
  command: () => link.lastSent, used: () => state.last?.used ?? -1, late: () => state.last?.late ?? 0,
  steps: () => state.last?.steps ?? 0, latency_ms: () => state.last?.latency_ms ?? null,
  claw: () => state.last?.claw ?? null, fps: () => view.framesPerSecond, shown_step: () => view.shownStep,
  paused: () => input.paused, device: () => input.command.device, result: () => outcome.result, linked: () => link.up,
};
window.ssmash = Object.freeze(
  Object.defineProperties({}, Object.fromEntries(Object.entries(reading).map(([k, get]) => [k, { get, enumerable: true }]))),
);
