"use strict";

const LOST_AFTER = 2000; // ms without a frame: what was shown is void
const RETRY_AFTER = 1000; // ms
const FIRST_WAIT = 5000; // ms until a connection that was refused is tried again
const SIGNS = {
  "up": "▲", "down": "▼", "turn": "↔", "turn-left": "↰", "turn-right": "↱", "hold": "◎",
  "go": "▶", "wait": "≈", "check": "✓", "more": "⇈", "less": "⇊", "cross": "✗", "unknown": "?",
  "danger": "!", "land": "▼",
};
const byId = (id) => document.getElementById(id);
const body = document.body;

// What the frames are about is text, never markup.
function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function create(parent, tag, name, text = "") {
  const element = document.createElement(tag);
  if (name) element.className = name;
  element.textContent = text;
  parent.append(element);
  return element;
}

// Cues

function showCue(cue) {
  setText(byId("word"), cue.status_text);
  setText(byId("sign"), SIGNS[cue.sign] ?? "");
  setText(byId("count"), cue.count);
  byId("cue").className = cue.tone;
  const letters = cue.status_text.length + (SIGNS[cue.sign] ? 2 : 0) + cue.count.length;
  byId("cue").style.setProperty("--letters", Math.max(letters, 5));
  byId("ring").hidden = cue.ring === null;
  byId("ring").firstChild.style.width = `${100 * (cue.ring ?? 0)}%`;
  const hints = byId("hints");
  hints.replaceChildren();
  for (const hint of cue.hints) create(hints, "li", hint.tone, hint.text);
  const gauges = byId("gauges");
  gauges.replaceChildren();
  cue.gauges.forEach((gauge) => showGauge(gauges, gauge));
  const leg = byId("leg");
  leg.hidden = !cue.leg_time_text;
  leg.className = cue.leg_short ? "short" : "";
  setText(leg.lastElementChild, cue.leg_time_text + (/\d/.test(cue.leg_time_text) ? " s" : ""));
  showCard(cue.card);
  setText(byId("footer"), cue.footer);
}

function showGauge(parent, gauge) {
  const box = create(parent, "div", "gauge");
  create(box, "h2", "", gauge.title);
  const number = create(box, "span", "number", gauge.number);
  create(number, "span", "unit", gauge.unit);
  create(box, "span", "target", gauge.target_text && `${gauge.target_text} ${gauge.unit}`);
  if (gauge.low === null || gauge.high === null) return;
  const track = create(box, "div", "track");
  const band = create(track, "div", "band");
  band.style.left = `${100 * gauge.low}%`;
  band.style.right = `${100 * (1 - gauge.high)}%`;
  if (gauge.marker !== null) {
    const place = Math.min(Math.max(gauge.marker, 0), 1);
    create(track, "div", "marker").style.left = `${100 * place}%`;
  }
}

function showCard(card) {
  const box = byId("card");
  box.hidden = !card.heading && !card.text;
  setText(box.querySelector(".heading"), card.heading);
  setText(box.querySelector(".text"), card.text);
  setText(box.querySelector(".benefit"), card.benefit_text);
  box.querySelector(".benefit").classList.toggle("problem", card.problem);
  setText(box.querySelector(".left"), [card.time_left_text, card.maneuvers_left_text]
    .filter(Boolean).join(" · "));
}

function showLast(last) {
  const box = byId("last");
  box.hidden = !last;
  if (!last) return;
  for (const name of ["title", "time", "result", "advice"]) {
    setText(box.querySelector(`.${name}`), last[name]);
  }
  box.querySelector(".result").className = `result ${last.tone}`;
}

// Strips

let curves = []; // of each line: {first, low, high}
let record = null;
let latest = null; // the newest frame
const strips = []; // {box, lines, canvas}

function takeColumns(frame) {
  if (frame.record !== record || curves.length !== frame.curves.length) {
    record = frame.record;
    curves = frame.curves.map(() => ({ first: frame.first, low: [], high: [] }));
  }
  const columns = Math.ceil((frame.window ?? 0) / (frame.column ?? 1));
  frame.curves.forEach(([low, high], index) => {
    const curve = curves[index];
    const known = Math.max(frame.first - curve.first, 0);
    while (curve.low.length < known) { curve.low.push(null); curve.high.push(null); }
    curve.low.splice(known, Infinity, ...low);
    curve.high.splice(known, Infinity, ...high);
    const excess = curve.low.length - columns;
    if (excess > 0) {
      curve.low.splice(0, excess);
      curve.high.splice(0, excess);
      curve.first += excess;
    }
  });
}

function showStrips(frame) {
  const parent = byId("strips");
  const wanted = frame.strips ?? [];
  while (strips.length > wanted.length) strips.pop().box.remove();
  while (strips.length < wanted.length) {
    const box = create(parent, "div", "strip");
    const lines = create(box, "div", "");
    strips.push({ box, lines, canvas: create(box, "canvas", "") });
  }
  let index = 0;
  wanted.forEach((strip, place) => {
    const shown = strips[place];
    shown.lines.replaceChildren();
    for (const line of strip.lines) showLine(shown.lines, strip, line);
    shown.box.classList.toggle("stale", strip.lines.every((line) => line.stale));
    drawStrip(shown.canvas, frame, strip, curves.slice(index, index + strip.lines.length));
    index += strip.lines.length;
  });
}

function showLine(parent, strip, line) {
  const row = create(parent, "div", "line");
  const color = dark.matches ? line.dark : line.color;
  create(row, "span", "title", line.title).style.color = color;
  create(row, "span", `note ${line.state}`, line.note);
  create(row, "span", "value", line.value).style.color = color;
  create(row, "span", "unit", strip.unit);
}

function clock(seconds) {
  const whole = Math.round(seconds);
  const two = (number) => String(number).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  const end = `${two(minutes % 60)}:${two(whole % 60)}`;
  return minutes >= 60 ? `${Math.floor(minutes / 60)}:${end}` : end;
}

function drawStrip(canvas, frame, strip, lines) {
  const scale = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const paint = canvas.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  const color = (name) => style.getPropertyValue(`--${name}`);
  const font = parseFloat(style.fontSize);
  paint.setTransform(scale, 0, 0, scale, 0, 0);
  paint.clearRect(0, 0, width, height);
  paint.font = `${0.875 * font}px system-ui, sans-serif`;
  const left = 3.6 * font, bottom = height - 1.4 * font, top = 0.4 * font;
  const end = (lines[0]?.first ?? 0) + (lines[0]?.low.length ?? 0);
  const now = end * frame.column;
  const x = (time) => width - 2 + (time - now) * (width - left - 2) / frame.window;
  const y = (value) => bottom - (value - strip.low) / (strip.high - strip.low) * (bottom - top);
  paint.lineWidth = 1;
  paint.strokeStyle = color("grid");
  paint.fillStyle = color("muted");
  paint.textBaseline = "middle";
  paint.textAlign = "right";
  paint.beginPath();
  for (const [value, text] of strip.ticks) {
    paint.moveTo(left, y(value));
    paint.lineTo(width, y(value));
    const inside = Math.min(Math.max(y(value), 0.5 * font), bottom - 0.3 * font);
    paint.fillText(text, left - 4, inside, left - 6);
  }
  paint.textBaseline = "bottom";
  paint.textAlign = "center";
  const step = width - left < 18 * font ? 20 : 10;
  for (let time = Math.ceil((now - frame.window) / step) * step; time <= now; time += step) {
    if (time < 0 || x(time) < left) continue;
    paint.moveTo(x(time), top);
    paint.lineTo(x(time), bottom);
    if (x(time) < width - 1.4 * font && x(time) > left + 0.8 * font) {
      paint.fillText(clock(time), x(time), height);
    }
  }
  paint.stroke();
  paint.save();
  paint.beginPath();
  paint.rect(left, 0, width - left, bottom + 1);
  paint.clip();
  lines.forEach((curve, index) => drawCurve(paint, frame, strip.lines[index], curve, x, y));
  paint.restore();
}

function drawCurve(paint, frame, line, curve, x, y) {
  paint.strokeStyle = dark.matches ? line.dark : line.color;
  paint.lineWidth = 2;
  paint.lineJoin = "round";
  paint.setLineDash(line.dashed ? [5, 3] : []);
  paint.beginPath();
  let joins = false;
  for (let index = 0; index < curve.low.length; index++) {
    const low = curve.low[index], high = curve.high[index];
    if (low === null || high === null) { joins = false; continue; }
    const place = x((curve.first + index + 0.5) * frame.column);
    if (joins) paint.lineTo(place, y(low)); else paint.moveTo(place, y(low));
    paint.lineTo(place, y(high));
    joins = true;
  }
  paint.stroke();
}

// Frames

const dark = window.matchMedia("(prefers-color-scheme: dark)");

function show(frame) {
  takeColumns(frame);
  latest = frame;
  body.classList.remove("lost");
  setText(byId("flight"), frame.flight ?? "");
  setText(byId("mode"), frame.mode ?? "");
  setText(byId("time"), frame.time ?? "");
  showCue(frame.cue);
  showLast(frame.last);
  showStrips(frame);
}

function showLost(word, text) {
  body.classList.add("lost");
  setText(byId("mode"), "");
  const none = { heading: "", text: "", benefit_text: "", time_left_text: "",
    maneuvers_left_text: "", problem: false };
  showCue({ status_text: word, sign: "unknown", tone: "unknown", ring: null, count: "",
    hints: [{ text, tone: "plain" }], gauges: [], leg_time_text: "", leg_short: false, card: none,
    footer: "" });
  for (const strip of strips) {
    strip.box.classList.add("stale");
    for (const value of strip.lines.querySelectorAll(".value")) setText(value, "–");
  }
}

const sleep = (time) => new Promise((resolve) => setTimeout(resolve, time));

async function receive() {
  const key = decodeURIComponent(location.hash.slice(1));
  const headers = key ? { Authorization: `Bearer ${key}` } : {};
  const breaker = new AbortController();
  let watchdog = setTimeout(() => breaker.abort(), FIRST_WAIT);
  try {
    const response = await fetch("frames", { headers, cache: "no-store", signal: breaker.signal });
    if (response.status === 401) return showLost(body.dataset.lost, body.dataset.refused);
    if (response.status === 503) return showLost(body.dataset.lost, body.dataset.busy);
    if (!response.ok) throw new Error(String(response.status));
    const reader = response.body.getReader();
    const decoder = new TextDecoder();
    let pending = "";
    curves = [];
    for (;;) {
      const { done, value } = await reader.read();
      if (done) throw new Error("closed");
      pending += decoder.decode(value, { stream: true });
      const lines = pending.split("\n");
      pending = lines.pop();
      for (const line of lines.slice(0, -1)) takeColumns(JSON.parse(line));
      if (lines.length) {
        clearTimeout(watchdog);
        watchdog = setTimeout(() => breaker.abort(), LOST_AFTER);
        show(JSON.parse(lines[lines.length - 1]));
      }
    }
  } catch (error) {
    console.log(error);
    showLost(body.dataset.lost, body.dataset.connecting);
  } finally {
    clearTimeout(watchdog);
  }
}

async function run() {
  showLost("…", body.dataset.connecting);
  for (;;) {
    await receive();
    await sleep(RETRY_AFTER);
  }
}

const redraw = () => { if (latest && !body.classList.contains("lost")) showStrips(latest); };
window.addEventListener("resize", redraw);
dark.addEventListener("change", redraw);
window.addEventListener("hashchange", () => location.reload());
run();
