// The deployment in 3D: frames of nodes and fields, drawn by k3d. The page gives the data, see report/deployment.py.
"use strict";

const LEVELS = 255;
const SIDES = 5, FEWER_SIDES = 3; // of the prism that shows a line
const MANY = 1500; // lines have prisms of fewer sides, without ends
const ROUND = 32; // sides of a cylinder

/** Bytes of a base64 text that were compressed by zlib. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

const KINDS = { int16: Int16Array, uint8: Uint8Array, uint32: Uint32Array, float32: Float32Array };

/** Views of the arrays of a run, by name. */
function arraysOf(buffer, places) {
  const found = {};
  for (const [name, { kind, offset, count }] of Object.entries(places))
    found[name] = new KINDS[kind](buffer, offset, count);
  return found;
}

const hex = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);

/** k3d's list of (value, red, green, blue): level 0 is a missing value, 1 to 255 are the scale. */
function colorMap(field, missing) {
  const stops = [0, ...hex(missing), 0.002, ...hex(missing)];
  const count = field.colors.length;
  field.colors.forEach((color, k) => {
    const rgb = hex(color);
    if (field.is_stepped) stops.push(Math.max(k / count, 0.002), ...rgb, (k + 1) / count - (k + 1 < count ? 1e-4 : 0), ...rgb); // k3d keeps one colour at a value
    else stops.push(Math.max(k / (count - 1), 0.002), ...rgb);
  });
  return { data: Float32Array.from(stops), shape: [stops.length] };
}

/** A frame of reference of three unit vectors, the third along (x, y, z). */
function across(x, y, z) {
  const length = Math.hypot(x, y, z) || 1;
  const w = [x / length, y / length, z / length];
  const u = Math.abs(w[2]) < 0.9 ? [-w[1], w[0], 0] : [0, -w[2], w[1]];
  const size = Math.hypot(...u) || 1;
  const v = u.map((c) => c / size);
  return [v, [w[1] * v[2] - w[2] * v[1], w[2] * v[0] - w[0] * v[2], w[0] * v[1] - w[1] * v[0]]];
}

/** Vertices and triangles of prisms, capped, each between two points. */
class Prisms {
  constructor(count, sides, isClosed = true) {
    this.sides = sides;
    this.vertices = new Float32Array(count * 2 * (sides + 1) * 3);
    this.indices = new Uint32Array(count * (isClosed ? 4 : 2) * sides * 3);
    this.ring = Array.from({ length: sides }, (_, k) => [
      Math.cos((2 * Math.PI * k) / sides), Math.sin((2 * Math.PI * k) / sides),
    ]);
    const per = 2 * (sides + 1);
    let at = 0;
    for (let n = 0; n < count; n++) {
      const a = n * per, b = a + sides + 1; // rings at a and b; the last vertex of each is its centre
      for (let k = 0; k < sides; k++) {
        const next = (k + 1) % sides;
        for (const i of [a + k, a + next, b + k, a + next, b + next, b + k]) this.indices[at++] = i;
        if (isClosed) for (const i of [a + sides, a + next, a + k, b + sides, b + k, b + next]) this.indices[at++] = i;
      }
    }
  }

  set(n, ax, ay, az, bx, by, bz, radius) {
    const [u, v] = across(bx - ax, by - ay, bz - az);
    let at = n * 2 * (this.sides + 1) * 3;
    for (const [x, y, z] of [[ax, ay, az], [bx, by, bz]]) {
      for (const [c, s] of this.ring) {
        this.vertices[at++] = x + radius * (c * u[0] + s * v[0]);
        this.vertices[at++] = y + radius * (c * u[1] + s * v[1]);
        this.vertices[at++] = z + radius * (c * u[2] + s * v[2]);
      }
      this.vertices[at++] = x; this.vertices[at++] = y; this.vertices[at++] = z;
    }
  }
}

const LENGTHS = ["centre", "half", "spool", "reaches", "reach", "distance", "centre_of_view", "line_radius", "tip_radius"];

/** A run with its reach as the unit of length: k3d shows what is about as large as 1, neither micrometres nor kilometres. */
function scaled(meta, arrays) {
  const divided = (value) => (value === null ? null : Array.isArray(value) ? value.map(divided) : value / meta.reach);
  const lengths = Object.fromEntries(LENGTHS.map((name) => [name, divided(meta[name])]));
  const solids = arrays.solids.map(divided), planes = arrays.planes.map(divided);
  return { meta: { ...meta, ...lengths }, arrays: { ...arrays, solids, planes } };
}

const PLAIN = { name: "", title: "Film", place: "triangles", is_stepped: true };

/** The scene of one run in k3d: `show` draws it at a place between two frames. */
class Deployment {
  constructor(K3D, meta, arrays, templates) {
    Object.assign(this, { K3D, ...scaled(meta, arrays) });
    meta = this.meta;
    this.templates = Object.fromEntries(templates.map((json) => [json.name, json]));
    this.field = null;
    this.points = new Float32Array(meta.node_count * 3);
    this.reach = null;
    this.isFixed = false;
    this.follows = meta.follows;
    this.queue = Promise.resolve();
  }

  /** Make the objects of k3d anew for a field, or for plain colours where that is null. */
  async color(name) {
    this.field = this.meta.fields.find((field) => field.name === name) || null;
    const { meta, arrays } = this, field = this.field;
    const onLines = field !== null && field.place === "lines";
    const map = field === null ? null : colorMap(field, meta.missing);
    const plain = (colors) => colorMap({ ...PLAIN, colors }, meta.missing);
    const wanted = {};
    if (meta.triangle_count) {
      const count = meta.triangle_count * 3;
      const film = { vertices: new Float32Array(count * 3), indices: Uint32Array.from({ length: count }, (_, k) => k) };
      const bare = onLines ? [meta.bare] : null;
      wanted.front = { ...film, map: bare ? plain(bare) : map || plain(meta.front), attribute: new Float32Array(count) };
      wanted.back = { ...film, vertices: film.vertices.slice(), map: bare ? plain(bare) : map || plain(meta.back), attribute: new Float32Array(count) };
      if (map === null || onLines) this.fillPlain(wanted);
    }
    this.shown = onLines ? arrays[`${field.name}-lines`] : arrays.outline;
    const isMany = this.shown.length > MANY, sides = isMany ? FEWER_SIDES : SIDES;
    this.prisms = new Prisms(this.shown.length, sides, !isMany);
    const perLine = 2 * (sides + 1);
    if (this.shown.length) {
      const attribute = new Float32Array(this.shown.length * perLine).fill(1);
      wanted.lines = { ...this.prisms, attribute, map: onLines ? map : plain([meta.line_color]) };
    }
    this.spool = new Prisms(meta.spool ? 1 : 0, ROUND);
    if (meta.spool) wanted.spool = { ...this.spool };
    this.solids = new Prisms(meta.solid_count, ROUND);
    if (meta.solid_count) wanted.bodies = { ...this.solids };
    this.mark = new Prisms(meta.spool ? 1 : 0, 4);
    if (meta.spool) wanted.mark = { ...this.mark };
    this.planes = new Float32Array(meta.plane_count * 12);
    if (meta.plane_count)
      wanted.planes = { vertices: this.planes, indices: Uint32Array.from({ length: meta.plane_count }, (_, k) => 4 * k).reduce((all, a) => (all.push(a, a + 1, a + 2, a, a + 2, a + 3), all), []) };
    this.tips = new Prisms(arrays.tips.length, 8);
    if (arrays.tips.length) wanted.tips = { ...this.tips };
    this.wanted = wanted;
    this.update(this.place || 0);
    await this.load(wanted);
  }

  async load(wanted) {
    const objects = [];
    for (const [name, json] of Object.entries(this.templates)) {
      const found = wanted[name];
      if (!found) continue;
      const indices = Uint32Array.from(found.indices);
      const object = { ...json, vertices: { data: found.vertices, shape: [found.vertices.length / 3, 3] }, indices: { data: indices, shape: [indices.length / 3, 3] } };
      if (found.map) {
        object.color_map = found.map;
        object.attribute = { data: found.attribute, shape: [found.attribute.length] };
      }
      objects.push(object);
    }
    for (const json of Object.values(this.K3D.getWorld().ObjectsListJson)) await this.K3D.removeObject(json.id);
    await this.K3D.load({ objects });
    await this.K3D.render();
  }

  /** Petals by their tones; one tone for a film without petals, or behind coloured lines. */
  fillPlain(wanted) {
    const tones = this.field === null ? this.meta.front.length : 1;
    for (const part of [wanted.front, wanted.back])
      this.arrays.petals.forEach((petal, k) => part.attribute.fill(tones === 1 ? 1 : (petal + 0.5) / tones, 3 * k, 3 * k + 3));
  }

  /** Draw at a place: 2.25 is a quarter behind frame 2. Calls come one after the other. */
  show(place) {
    this.queue = this.queue.then(() => this.draw(place)).catch((error) => console.error(error));
    return this.queue;
  }

  async draw(place) {
    this.update(place);
    const changes = [];
    for (const [name, part] of Object.entries(this.wanted)) {
      const json = this.K3D.getWorld().ObjectsListJson[this.templates[name].id];
      if (!json || name === "mark" && !this.isFixed && this.marked) continue;
      const change = { vertices: { data: part.vertices, shape: json.vertices.shape } };
      if (part.map && (this.field && this.field.place !== "lines" ? name !== "lines" : this.field && name === "lines"))
        change.attribute = { data: part.attribute, shape: [part.attribute.length] };
      Object.assign(json, change);
      changes.push(this.K3D.reload(json, change, true));
    }
    this.marked = !this.isFixed;
    await Promise.all(changes);
    await this.K3D.render();
  }

  /** Arrays of the objects at a place. */
  update(place) {
    const { meta, arrays } = this, last = meta.times.length - 1;
    const low = Math.min(Math.floor(place), last), high = Math.min(low + 1, last), share = place - low;
    this.place = place;
    this.time = meta.times[low] + share * (meta.times[high] - meta.times[low]);
    const angle = this.isFixed ? meta.hub_angles[low] + share * (meta.hub_angles[high] - meta.hub_angles[low]) : 0;
    this.turn = [Math.cos(angle), Math.sin(angle)];
    this.movePoints(low, high, share);
    if (meta.triangle_count) this.moveFilm(low, high, share);
    this.moveLines(low, high, share);
    this.moveRest(low, high, share);
    const reach = meta.reaches[low] + share * (meta.reaches[high] - meta.reaches[low]);
    if (this.follows && this.reach && reach !== this.reach) this.zoom(reach / this.reach);
    this.reach = reach;
  }

  turned(x, y) {
    const [c, s] = this.turn;
    return [c * x - s * y, s * x + c * y];
  }

  movePoints(low, high, share) {
    const { meta, arrays, points } = this, size = points.length, from = arrays.positions;
    const scale = meta.half / 32767;
    for (let k = 0; k < size; k += 3) {
      const p = [0, 1, 2].map((axis) => {
        const a = from[low * size + k + axis], b = from[high * size + k + axis];
        return meta.centre[axis] + scale * (a + share * (b - a));
      });
      [points[k], points[k + 1]] = this.turned(p[0], p[1]);
      points[k + 2] = p[2];
    }
  }

  /** Level of a field between two frames, as a share of the scale; nearest where a value is missing or is a category. */
  level(a, b, share) {
    return (a && b && !this.field.is_stepped ? a + share * (b - a) : share < 0.5 ? a : b) / LEVELS;
  }

  moveFilm(low, high, share) {
    const { arrays, points, wanted, field, meta } = this, corners = arrays.triangles;
    const { front, back } = wanted, vertices = front.vertices;
    for (let k = 0; k < corners.length; k++)
      for (let axis = 0; axis < 3; axis++) vertices[3 * k + axis] = points[3 * corners[k] + axis];
    back.vertices.set(vertices);
    if (field === null || field.place === "lines") return;
    const levels = arrays[field.name], attribute = front.attribute;
    if (field.place === "triangles") {
      const count = meta.triangle_count;
      for (let k = 0; k < count; k++)
        attribute.fill(this.level(levels[low * count + k], levels[high * count + k], share), 3 * k, 3 * k + 3);
    } else {
      const count = meta.node_count;
      for (let k = 0; k < corners.length; k++)
        attribute[k] = this.level(levels[low * count + corners[k]], levels[high * count + corners[k]], share);
    }
    back.attribute.set(attribute);
  }

  moveLines(low, high, share) {
    const { arrays, points, meta, field, wanted } = this, onLines = field !== null && field.place === "lines";
    const radius = meta.line_radius * (!onLines ? 1 : this.shown.length > MANY ? 1.5 : 4) * this.scale();
    const levels = onLines ? arrays[field.name] : null, per = 2 * (this.prisms.sides + 1), count = this.shown.length;
    this.shown.forEach((line, n) => {
      const a = 3 * arrays.lines[2 * line], b = 3 * arrays.lines[2 * line + 1];
      const level = levels === null ? 1 : this.level(levels[low * count + n], levels[high * count + n], share);
      this.prisms.set(n, points[a], points[a + 1], points[a + 2], points[b], points[b + 1], points[b + 2], level ? radius : 0.3 * radius);
      if (onLines) wanted.lines.attribute.fill(level, n * per, (n + 1) * per);
    });
  }

  /** Size of what has a size on the screen, relative to that of the whole run. */
  scale() {
    return this.follows ? (this.reach || this.meta.reaches[0]) / this.meta.reach : 1;
  }

  moveRest(low, high, share) {
    const { arrays, points, meta } = this;
    arrays.tips.forEach((node, n) => {
      const [x, y, z] = points.slice(3 * node, 3 * node + 3), radius = meta.tip_radius * this.scale();
      this.tips.set(n, x, y, z - radius, x, y, z + radius, radius);
    });
    if (meta.spool) {
      const [radius, bottom, top] = meta.spool;
      this.spool.set(0, 0, 0, bottom, 0, 0, top, radius);
      const [x, y] = this.turned(0.15 * radius, 0), [u, v] = this.turned(0.9 * radius, 0), height = top + 0.02 * radius;
      this.mark.set(0, x, y, height, u, v, height, 0.08 * radius);
    }
    const near = share < 0.5 ? low : high, between = (array, at, k, count) => {
      const a = array[low * count + at + k], b = array[high * count + at + k];
      return a + share * (b - a);
    };
    for (let k = 0; k < meta.solid_count; k++) {
      const at = 7 * k, count = 7 * meta.solid_count;
      const radius = arrays.solids[near * count + at + 6];
      const is_there = arrays.solids[low * count + at + 6] && arrays.solids[high * count + at + 6];
      const p = [0, 1, 2, 3, 4, 5].map((c) => (is_there ? between(arrays.solids, at, c, count) : arrays.solids[near * count + at + c]));
      this.solids.set(k, ...this.turned(p[0], p[1]), p[2], ...this.turned(p[3], p[4]), p[5], radius);
    }
    for (let k = 0; k < this.planes.length; k += 3) {
      const count = this.planes.length;
      [this.planes[k], this.planes[k + 1]] = this.turned(between(arrays.planes, k, 0, count), between(arrays.planes, k, 1, count));
      this.planes[k + 2] = between(arrays.planes, k, 2, count);
    }
  }

  zoom(ratio) {
    const c = this.K3D.getWorld().controls.getCameraArray();
    for (let k = 0; k < 3; k++) c[k] = c[k + 3] + (c[k] - c[k + 3]) * ratio;
    this.K3D.setCamera(c);
  }

  /** The camera of the pictures, for the size now; farther where the picture is hardly wider than high. */
  aim() {
    const { meta } = this, taller = Math.max(1, 1.1 / this.K3D.getWorld().camera.aspect);
    const distance = (taller * meta.distance * (this.follows ? this.reach : meta.reach)) / meta.reach;
    this.K3D.setCamera([...meta.centre_of_view.map((c, k) => c + distance * meta.view[k]), ...meta.centre_of_view, ...meta.up]);
  }
}
