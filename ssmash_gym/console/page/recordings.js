// The page of `ssmash view`: the runs that the server has, or those that were written into the page, in one player.
import { Player } from "./scene/player.js";

async function runs() {
  const inside = document.getElementById("runs");
  if (inside) return JSON.parse(inside.textContent).runs;
  const answer = await fetch("/runs.json");
  if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
  return (await answer.json()).runs;
}

const root = document.getElementById("player");
const wish = new URLSearchParams(location.search);
try {
  const found = await runs();
  document.title = `${found.map((run) => run.name).join(", ")} - ssmash_gym`;
  const quality = wish.has("quality") ? Number(wish.get("quality")) : null;
  const player = new Player(root, found, { quality, camera: wish.get("view") ?? "follow" });
  if (wish.has("time")) player.seek(Number(wish.get("time")));
  root.focus();
  globalThis.player = player; // for a console, and for tests
} catch (trouble) {
  const note = document.createElement("p");
  note.className = "view-note";
  note.setAttribute("role", "alert");
  note.textContent = `The recordings cannot be shown: ${trouble.message}.`;
  root.replaceChildren(note);
}
