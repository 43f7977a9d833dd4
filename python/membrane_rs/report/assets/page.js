// What the controls of the page do: runs, play, time, colours, and the time in the curves.
"use strict";

const byId = (id) => document.getElementById(id);
const dark = matchMedia("(prefers-color-scheme: dark)");
const FRAMES_PER_SECOND = 8; // of the run, at speed 1

/** Times with as many digits as tell them apart. */
function timeText(meta, time) {
  return `${time.toFixed(meta.digits)} s`;
}

class Viewer {
  constructor(runs) {
    this.runs = runs;
    this.place = 0;
    this.playing = false;
    this.turn = this.waiting = 0;
    this.opening = Promise.resolve();
    this.controls = Object.fromEntries(
      ["run", "field", "frame", "speed", "follow", "play", "time", "home", "label", "scale", "view"].map((name) => [name, byId(`view-${name}`)]),
    );
    this.listen();
  }

  listen() {
    const { run, field, frame, follow, play, time, home, view } = this.controls;
    if (run) run.onchange = () => this.open(run.selectedIndex);
    field.onchange = () => this.colour();
    frame.onchange = () => { this.shape.isFixed = frame.value === "fixed"; this.redraw(); };
    follow.onchange = () => { this.shape.follows = follow.checked; this.shape.aim(); this.redraw(); };
    play.onclick = () => (this.playing ? this.pause() : this.play());
    time.oninput = () => { this.pause(); this.seek(Number(time.value)); };
    home.onclick = () => { this.shape.aim(); this.redraw(); };
    document.onkeydown = (event) => {
      const steps = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity };
      if (event.ctrlKey || event.altKey || event.metaKey || event.shiftKey || !this.shape) return;
      // Where no control has the focus and the picture is in sight: all but Home and End, which scroll the page.
      const isPage = event.target === document.body && !["Home", "End"].includes(event.key)
        && view.getBoundingClientRect().bottom > 0;
      if (event.target !== view && !isPage) return;
      if (event.key === " ") play.click();
      else if (event.key in steps) { this.pause(); this.seek(Math.round(this.place) + steps[event.key]); }
      else return;
      event.preventDefault();
    };
    dark.addEventListener("change", () => this.background());
  }

  /** Show a run, after those that were chosen before; one is left out where another was chosen meanwhile. */
  async open(index) {
    const turn = (this.turn = this.turn + 1);
    this.waiting += 1;
    this.controls.view.dataset.state = "loading";
    this.opening = this.opening.then(() => (turn === this.turn ? this.change(index) : null));
    await this.opening;
    this.waiting -= 1;
    this.done();
  }

  /** Show a run: its data are unpacked when it is chosen. */
  async change(index) {
    const { run, meta, note } = this.runs[index];
    this.pause();
    this.meta = meta;
    byId("view-note").textContent = note;
    for (const id of ["view-stage", "view-controls", "view-help"]) byId(id).hidden = meta === null;
    document.dispatchEvent(new CustomEvent("membrane-run", { detail: { run } }));
    this.shape = null;
    byId("view-failed").hidden = true;
    try {
      if (meta !== null) await this.load(index);
    } catch (error) {
      this.fail(error);
    }
  }

  /** Unpack the data of a run and draw it. */
  async load(index) {
    const { meta } = this;
    if (this.failed && !this.K3D) throw this.failed;
    if (!this.K3D) {
      this.K3D = await startK3D(this.controls.view);
      this.templates = Object.values(this.K3D.getWorld().ObjectsListJson).map((json) => ({ ...json }));
      this.background();
    }
    const buffer = await unpacked(byId(`data-${index}`).textContent.trim());
    this.shape = new Deployment(this.K3D, meta, arraysOf(buffer, meta.arrays), this.templates);
    const { field, frame, follow, time } = this.controls, before = field.value;
    field.replaceChildren(...[PLAIN, ...meta.fields].map((one) => new Option(one.title, one.name)));
    field.value = meta.fields.some((one) => one.name === before) ? before : "";
    frame.disabled = !meta.turns;
    frame.value = "turning";
    follow.checked = meta.follows;
    follow.disabled = !meta.can_follow;
    time.max = meta.times.length - 1;
    this.place = meta.times.length - 1;
    await this.colour();
    this.shape.aim();
    await this.seek(this.place);
  }

  /** Say why there is no picture in 3D; all else goes on. */
  fail(error) {
    this.failed = error;
    this.shape = null;
    byId("view-failed").hidden = false;
    byId("view-reason").textContent = error.message;
    byId("view-note").textContent = "";
    for (const id of ["view-stage", "view-controls", "view-help"]) byId(id).hidden = true;
    this.seek(this.meta.times.length - 1);
  }

  done() {
    if (this.waiting === 0) this.controls.view.dataset.state = "ready";
  }

  background() {
    if (!this.K3D) return;
    const colour = getComputedStyle(document.documentElement).getPropertyValue("--canvas").trim();
    this.K3D.setClearColor(parseInt(colour.slice(1), 16));
    this.K3D.render();
  }

  async colour() {
    const { field, view } = this.controls;
    view.dataset.state = "loading";
    this.shape.place = this.place;
    this.shape.queue = this.shape.queue.then(() => this.shape.color(field.value));
    await this.shape.queue;
    this.scale();
    await this.seek(this.place);
    this.done();
  }

  /** The scale of colours below the picture. */
  scale() {
    const field = this.shape.field, { scale } = this.controls;
    scale.hidden = field === null;
    if (field === null) return;
    const bar = document.createElement("div"), words = document.createElement("div");
    bar.className = "bar";
    words.className = "ends";
    const stops = field.colors.map((color, k) => (field.is_stepped
      ? `${color} ${(100 * k) / field.colors.length}% ${(100 * (k + 1)) / field.colors.length}%` : color));
    bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    words.replaceChildren(...field.ticks.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
    words.classList.toggle("stepped", field.is_stepped);
    const title = Object.assign(document.createElement("div"), { textContent: field.title });
    const note = Object.assign(document.createElement("small"), { textContent: field.note });
    scale.replaceChildren(title, bar, words, note);
  }

  redraw() {
    return this.seek(this.place);
  }

  async seek(place) {
    const last = this.meta.times.length - 1;
    this.place = Math.min(Math.max(place, 0), last);
    const { time, label, view } = this.controls;
    time.value = Math.round(this.place);
    if (this.shape) await this.shape.show(this.place);
    const now = this.shape ? this.shape.time : this.meta.times[Math.round(this.place)];
    const text = timeText(this.meta, now), stage = this.meta.stages[Math.round(this.place)];
    label.textContent = stage ? `${text} · ${stage}` : text;
    time.setAttribute("aria-valuetext", label.textContent);
    view.dataset.place = String(this.place);
    document.dispatchEvent(new CustomEvent("membrane-time", { detail: { time: now } }));
  }

  play() {
    if (this.place >= this.meta.times.length - 1) this.place = 0;
    this.setPlaying(true);
    let before = performance.now();
    const step = async () => {
      if (!this.playing) return;
      const now = performance.now(), speed = FRAMES_PER_SECOND * Number(this.controls.speed.value);
      const next = this.place + ((now - before) / 1000) * speed;
      before = now;
      await this.seek(next);
      if (next >= this.meta.times.length - 1) this.setPlaying(false);
      else if (this.playing) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    if (!this.playing) return;
    this.setPlaying(false);
    this.seek(Math.round(this.place));
  }

  setPlaying(playing) {
    const { play, view } = this.controls;
    this.playing = playing;
    play.textContent = playing ? "❚❚ Pause" : "▶ Play";
    view.dataset.playing = String(playing);
  }
}

/** k3d, from the text in the page, in an element of it. */
async function startK3D(element) {
  const source = new TextDecoder().decode(await unpacked(byId("k3d-source").textContent.trim()));
  let library = null;
  window.define = (_, __, factory) => { library = factory(); };
  const script = document.createElement("script");
  script.textContent = source;
  document.head.append(script);
  const snapshot = Uint8Array.from(atob(byId("k3d-plot").textContent.trim()), (letter) => letter.charCodeAt(0));
  return library.CreateK3DAndLoadBinarySnapshot(snapshot, byId("view-canvas"));
}

/** A line at the time of the picture in each curve; a click on a curve goes to its time. */
function followInCurves(viewer) {
  const figures = [...document.querySelectorAll("svg[data-time-scale]")].map((svg) => {
    const [x0, x1, t0, t1, top, bottom] = svg.dataset.timeScale.split(" ").map(Number);
    const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
    line.setAttribute("class", "now");
    line.setAttribute("y1", top);
    line.setAttribute("y2", bottom);
    svg.append(line);
    svg.addEventListener("click", (event) => {
      if (!viewer.meta) return;
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const time = t0 + ((point.x - x0) / (x1 - x0)) * (t1 - t0), times = viewer.meta.times;
      viewer.pause();
      viewer.seek(times.reduce((best, value, k) => (Math.abs(value - time) < Math.abs(times[best] - time) ? k : best), 0));
    });
    return { line, at: (time) => x0 + ((time - t0) / (t1 - t0)) * (x1 - x0), t0, t1 };
  });
  document.addEventListener("membrane-time", ({ detail: { time } }) => {
    for (const { line, at, t0, t1 } of figures) {
      line.style.display = time < t0 || time > t1 ? "none" : "";
      line.setAttribute("x1", at(time));
      line.setAttribute("x2", at(time));
    }
    for (const cell of document.querySelectorAll("[data-samples]")) {
      const { times, values } = (cell.samples ||= JSON.parse(cell.dataset.samples));
      let k = times.findIndex((value) => value >= time);
      k = k < 0 ? times.length - 1 : k;
      cell.textContent = values[k] === null ? "?" : values[k];
    }
  });
  for (const box of document.querySelectorAll("input[data-shows]"))
    box.addEventListener("change", () => {
      for (const curve of document.querySelectorAll(`.${box.dataset.shows}`)) curve.style.display = box.checked ? "" : "none";
    });
}

async function start() {
  const content = JSON.parse(byId("deployments").textContent);
  const viewer = new Viewer(content.runs);
  followInCurves(viewer);
  for (const section of document.querySelectorAll("[data-of-run]"))
    document.addEventListener("membrane-run", ({ detail: { run } }) => { section.hidden = section.dataset.ofRun !== run; });
  await viewer.open(0);
}

start();
