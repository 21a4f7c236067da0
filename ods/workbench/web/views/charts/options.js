// A described chart as ECharts' options. All places are computed here: the axes' ends are given, and so is each grid.
import { gridInk, ink, legendRows, paper, styleOf, ticks } from "./index.js";

const MARGIN = { left: 56, right: 14, bottom: 38 };
const TITLE = 22;
export const ROW = 17; // of a strip
const [LEGEND_ROW, LEGEND_GAP] = [20, 8];
const LABEL = { least: 84, most: 190 }; // of a strip's name
const [NAMES, NAME] = [150, 15]; // width and height of names beside points
const GAP = { across: 62, down: 24, wide: 46 };
const FONT = { fontFamily: "system-ui, sans-serif", fontSize: 12 };
const STATES = ["tentative", "active", "stand_by", "hibernated", "terminated"];
const DOTS = ["dotted", "points", "bars"];
const BARS = { type: "bar", barCategoryGap: "0%", itemStyle: { opacity: 0.55 }, large: true, largeThreshold: 1 }; // one path
const measuring = document.createElement("canvas").getContext("2d");

const linesOf = (role) => ({ ...styleOf(role), type: styleOf(role).dash.length ? styleOf(role).dash : "solid" });
const withNames = (panel) => panel.curves.some((curve) => curve.names.length);

// [[role, label], ...] of all that has a name, each once.
function entriesOf({ panels, strips }) {
  const states = STATES.filter((role) => strips.some(({ spans }) => spans.some(([each]) => each === role)));
  const named = panels.flatMap(({ curves, bands }) => [...curves, ...bands]).filter(({ label }) => label);
  const all = [...states.map((role) => [role, styleOf(role).label]), ...named.map(({ role, label }) => [role, label])];
  return [...new Map(all.map((entry) => [entry[1], entry])).values()];
}

// Where the strips and the panels are on a canvas of that size, [{x, y, width, height}, ...]; null: there is no room.
export function arranged(chart, [width, height], titled) {
  measuring.font = `12px ${FONT.fontFamily}`;
  const entries = entriesOf(chart);
  const legend = entries.length > 1 || chart.strips.length ? entries : [];
  const placed = legendRows(measuring, legend, width - 16, LEGEND_GAP);
  const legendTop = titled ? TITLE : 4;
  let top = legendTop + (placed.length ? (placed[placed.length - 1][3] + 1) * LEGEND_ROW : 0) + 6;
  const laid = { legend, legendTop, width, strips: null, panels: [] };
  const { strips, panels } = chart;
  if (strips.length) {
    const widest = Math.max(...strips.map((strip) => measuring.measureText(`▸ ${strip.label}`).width * 1.1));
    const left = Math.min(LABEL.most, Math.max(LABEL.least, widest + 12), 0.4 * width);
    laid.strips = { x: left, y: top, width: width - left - MARGIN.right, height: ROW * strips.length };
    top += laid.strips.height + (panels.length ? MARGIN.bottom - 14 : MARGIN.bottom);
  }
  if (!panels.length) return laid;
  if (panels.some((panel) => panel.title || panel.lines.some(({ axis }) => axis === "x"))) top += 14;
  const columns = Math.min(chart.columns, panels.length);
  const lines = Math.ceil(panels.length / columns);
  const [across, right] = [columns > 1 ? GAP.across : 0, panels.some(withNames) ? NAMES : MARGIN.right];
  const wide = (width - MARGIN.left - right - (columns - 1) * across) / columns;
  const high = (height - top - MARGIN.bottom - (lines - 1) * GAP.down) / lines;
  if (high < 16 || wide < 40) return null;
  laid.panels = panels.map((_, place) => ({
    x: MARGIN.left + (place % columns) * (wide + across), y: top + Math.floor(place / columns) * (high + GAP.down),
    width: wide, height: high, last: place + columns >= panels.length, named: place === (lines - 1) * columns,
  }));
  return laid;
}

// Options for what of the chart is shown: ends.x of all, ends.y of each panel.
export function optionsOf(chart, laid, ends, title) {
  const strips = laid.strips ? [{ ...laid.strips, last: true, named: !laid.panels.length }] : [];
  const boxes = [...laid.panels, ...strips];
  return {
    animation: false,
    textStyle: { ...FONT, color: ink() },
    title: titles(chart, laid, title),
    legend: { id: "legend", ...legendOf(chart, laid) },
    grid: boxes.map(({ x, y, width, height }, place) => (
      { id: `g${place}`, left: x, top: y, width, height, outerBoundsMode: "none", show: true, borderColor: gridInk() })),
    xAxis: boxes.map((box, place) => ({
      ...axis(`x${place}`, place, chart.x, ends.x, box.width / 70), nameGap: 21,
      name: box.named ? chart.x.label : "",
      ...(box.last ? {} : { axisLabel: { show: false } }),
    })),
    yAxis: [
      ...chart.panels.map((panel, place) => ({
        ...axis(`y${place}`, place, panel.y, ends.y[place], Math.max(3, laid.panels[place].height / 26)),
        name: panel.title ? "" : panel.y.label, nameGap: 41, inverse: panel.y.inverse,
      })),
      ...(laid.strips ? [stripAxis(chart.strips, chart.panels.length)] : []),
    ],
    series: [
      ...chart.panels.flatMap((panel, place) => panelSeries(panel, place, laid.panels[place], { ...ends, y: ends.y[place] })),
      ...(laid.strips ? stripSeries(chart.strips, chart.panels.length) : []),
    ],
  };
}

const written = (id, text, left, top, more = {}) => (
  { id, text, left, top, padding: 0, textStyle: { ...FONT, color: ink(), fontWeight: "normal" }, ...more });

function titles(chart, laid, title) {
  const panels = chart.panels.map((panel, place) => {
    const { x, y } = laid.panels[place];
    return written(`t${place}`, panel.title, Math.min(x, laid.width - measuring.measureText(panel.title).width - 6), y - 16);
  });
  return [written("title", title, 8, 5), ...panels];
}

function legendOf(chart, laid) {
  const bands = new Set(chart.panels.flatMap((panel) => panel.bands.map((band) => band.label)));
  const curves = chart.panels.flatMap((panel) => panel.curves);
  const drawn = (styles) => new Set(curves.filter(({ style }) => styles.includes(style)).map(({ label }) => label));
  const [dots, diamonds] = [drawn(DOTS), drawn(["diamonds"])];
  const states = new Set(chart.strips.length ? STATES.map((role) => styleOf(role).label) : []);
  const data = laid.legend.map(([role, name]) => {
    if (bands.has(name)) return { name, icon: "rect", itemStyle: { color: styleOf(role).colour, opacity: 0.3 } };
    if (states.has(name)) return { name, icon: "rect" };
    if (diamonds.has(name)) return { name, icon: "path://M5,0L10,5L5,10L0,5Z" };
    return { name, itemStyle: { opacity: dots.has(name) ? 1 : 0 } }; // of a line it would be a dot
  });
  return {
    show: data.length > 0, data, left: 8, top: laid.legendTop, padding: 0, itemGap: LEGEND_GAP, itemWidth: 22, itemHeight: 9,
    textStyle: { ...FONT, color: ink() }, inactiveColor: gridInk(),
  };
}

// Ticks and labels are ours: ECharts' own begin at an axis's end, which is anywhere.
function axis(id, gridIndex, { log }, [min, max], most) {
  const texts = new Map(log ? decades(min, max) : ticks(min, max, most));
  const at = { customValues: [...texts.keys()] };
  return {
    id, gridIndex, type: log ? "log" : "value", min, max, containShape: false, // or bars would move the ends
    nameLocation: "middle", nameMoveOverlap: false, nameTextStyle: { ...FONT, color: ink() },
    axisLine: { show: false }, axisTick: { show: false, ...at }, splitLine: { ...at, lineStyle: { color: gridInk() } },
    axisLabel: { show: true, color: ink(), margin: 5, ...FONT, hideOverlap: true, ...at, formatter: (value) => textAt(texts, value) },
  };
}

// ECharts' value may be another by rounding.
function textAt(texts, value) {
  const near = [...texts].find(([tick]) => Math.abs(tick - value) <= 1e-9 * (Math.abs(tick) + 1));
  return near ? near[1] : "";
}

// Of a logarithmic axis; of a short one between the powers of ten, too.
function decades(min, max) {
  const steps = max < 100 * min ? [1, 2, 5] : [1];
  const values = Array.from({ length: 12 }, (_, place) => steps.map((step) => Number(`${step}e${place - 3}`))).flat();
  const shown = values.filter((value) => value >= min && value <= max);
  return shown.map((value) => [value, value < 1000 ? String(value) : `${value / 1000}k`]);
}

function panelSeries(panel, place, box, ends) {
  const on = { xAxisIndex: place, yAxisIndex: place };
  const names = namesBeside(panel, box, ends);
  return [
    ...panel.bands.map((band, k) => ({ id: `band ${place} ${k}`, ...on, ...bandSeries(band) })),
    ...panel.curves.map((curve, k) => ({ id: `curve ${place} ${k}`, ...on, ...curveSeries(curve, names.get(curve), ends.whole) })),
    { id: `lines ${place}`, ...on, type: "line", data: [], silent: true, z: 4, markLine: marks(panel.lines) },
  ];
}

function curveSeries({ role, label, x, y, style, names }, beside, whole) {
  const { colour, width, type } = linesOf(role);
  const shared = { name: label, silent: true, color: colour, emphasis: { disabled: true } };
  if (names.length) {
    const data = [...x].map((at, k) => ({ name: names[k], value: [at, y[k]] }));
    return { ...shared, ...points(colour, data, style, beside) };
  }
  const data = new Float32Array(2 * x.length);
  for (let k = 0; k < x.length; k++) [data[2 * k], data[2 * k + 1]] = [x[k], y[k]];
  const typed = { ...shared, data, dimensions: ["x", "y"] };
  if (style === "bars") return { ...typed, ...BARS };
  if (style === "points") return { ...typed, type: "scatter", symbolSize: 8 };
  return {
    ...typed, type: "line", lineStyle: { color: colour, width: Math.min(width, 1.6), type },
    symbol: style === "dotted" ? "circle" : "none", symbolSize: 6, step: style === "steps" ? "middle" : false,
    sampling: whole ? "max" : null, // small echoes stay; of a part all is drawn
  };
}

const points = (colour, data, style, beside) => ({
  type: "scatter", data, symbol: style === "diamonds" ? "diamond" : "circle", symbolSize: style === "diamonds" ? 18 : 9,
  label: { show: true, formatter: "{b}", position: "right", color: colour, ...FONT },
  labelLayout: ({ dataIndex }) => ({ ...beside[dataIndex], align: "left", verticalAlign: "middle" }),
  labelLine: { show: true, length2: 5, lineStyle: { color: colour } },
});

// Names of points stand in a column beside the panel, in the order of their heights, as points are often as good as others:
// of each curve with names [{x, y}, ...].
function namesBeside(panel, box, ends) {
  const named = panel.curves.filter(({ names }) => names.length);
  const [low, high] = ends.y;
  const all = named.flatMap((curve) => curve.names.map((_, k) => (
    { curve, k, y: box.y + (1 - (curve.y[k] - low) / (high - low)) * box.height })));
  all.sort((one, other) => one.y - other.y);
  const bottom = box.y + box.height;
  all.forEach((name, place) => (name.y = Math.max(name.y, place ? all[place - 1].y + NAME : box.y)));
  for (let place = all.length - 1; place >= 0; place--)
    all[place].y = Math.min(all[place].y, place + 1 < all.length ? all[place + 1].y - NAME : bottom);
  const found = new Map(named.map((curve) => [curve, []]));
  for (const { curve, k, y } of all) found.get(curve)[k] = { x: box.x + box.width + 24, y };
  return found;
}

function bandSeries({ role, label, x, low, high }) {
  const { colour } = styleOf(role);
  const parts = [[]];
  x.forEach((_, k) => (Number.isNaN(low[k]) ? parts.push([]) : parts[parts.length - 1].push(k)));
  const polygon = (api, part) => ({
    type: "polygon", style: { fill: colour, opacity: 0.2 },
    shape: { points: [...part.map((k) => api.coord([x[k], high[k]])), ...part.reverse().map((k) => api.coord([x[k], low[k]]))] },
  });
  return {
    type: "custom", name: label, silent: true, color: colour, clip: true, data: [[0, 0]], z: 1,
    renderItem: (_, api) => ({ type: "group", children: parts.filter((part) => part.length).map((part) => polygon(api, [...part])) }),
  };
}

// What can be dragged is shown by a whole, strong line. Names of two lines across stand on sides that are away from each other.
function marks(lines) {
  const data = lines.map(({ name, axis: across, value, role, draggable }) => {
    const isLow = name === "low";
    const upright = { position: "end", distance: 2, align: isLow ? "right" : "left" };
    const level = { position: isLow ? "insideStartBottom" : "insideStartTop", distance: 3 };
    const label = { formatter: name, color: styleOf(role).colour, textBorderColor: paper(), textBorderWidth: 3, ...FONT };
    const lineStyle = { color: styleOf(role).colour, width: draggable ? 2 : 1.2, type: draggable ? "solid" : [4, 3] };
    return {
      [across === "x" ? "xAxis" : "yAxis"]: value, lineStyle,
      label: { show: Boolean(name), ...label, ...(across === "x" ? upright : level) },
    };
  });
  return { animation: false, silent: true, symbol: "none", emphasis: { disabled: true }, data };
}

const stripAxis = (strips, gridIndex) => ({
  id: `y${gridIndex}`, gridIndex, type: "category", inverse: true, axisLine: { show: false }, axisTick: { show: false },
  splitLine: { show: false },
  data: strips.map(({ label, marked }) => (
    { value: `${marked ? "▸ " : ""}${label}`, textStyle: { fontWeight: marked ? "bold" : "normal" } })),
  axisLabel: { ...FONT, color: ink(), interval: 0, margin: 8, width: LABEL.most - 12, overflow: "truncate" },
});

// A state is shown by its pattern, too: an outline, or half height.
function stripSeries(strips, place) {
  const spans = strips.flatMap((strip, row) => strip.spans.map(([role, from, to]) => ({ role, at: [from, row, to] })));
  return STATES.map((role) => {
    const outlined = role === "tentative" || role === "hibernated";
    const high = role === "tentative" ? 9 : role === "active" ? 11 : 5;
    const colour = styleOf(role).colour;
    const look = outlined ? { fill: "none", stroke: colour, lineWidth: 1.5 } : { fill: colour };
    return {
      id: `state ${role}`, type: "custom", name: styleOf(role).label, silent: true, color: colour, clip: true,
      xAxisIndex: place, yAxisIndex: place, itemStyle: outlined ? { color: "transparent", borderColor: colour, borderWidth: 1.5 } : {},
      encode: { x: [0, 2], y: 1 }, data: spans.filter((span) => span.role === role).map(({ at }) => at),
      renderItem: (_, api) => {
        const [[x1, y], [x2]] = [api.coord([api.value(0), api.value(1)]), api.coord([api.value(2), api.value(1)])];
        return { type: "rect", shape: { x: x1, y: y - high / 2, width: Math.max(2, x2 - x1), height: high }, style: look };
      },
    };
  });
}
