// Draws the charts, filters and sorts the gallery, and shows or hides layers of the 3D views.
'use strict';

// Text and lines use the text color of the page, so one drawing fits light, dark and print.
const chartStyle = {
  background: null,
  font: 'system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif',
  view: {stroke: null},
  axis: {
    labelColor: 'currentColor', titleColor: 'currentColor', domainColor: 'currentColor',
    tickColor: 'currentColor', gridColor: 'currentColor', gridOpacity: 0.13, labelOverlap: true,
    labelFontSize: 12, titleFontSize: 12, titleFontWeight: 'normal',
  },
  legend: {labelColor: 'currentColor', titleColor: 'currentColor', labelFontSize: 12,
    symbolSize: 110, symbolOpacity: 1},
  text: {color: 'currentColor', fontSize: 12},
  point: {color: '#0072b2'},
};

// Limits the width of names, so that the chart has room on a phone too.
function styleFor(width) {
  return {...chartStyle, axisY: {labelLimit: Math.max(80, 0.3 * width)},
    legend: {...chartStyle.legend, labelLimit: Math.max(120, width - 90)}};
}

async function drawCharts() {
  for (const plot of document.querySelectorAll('.plot')) {
    const spec = JSON.parse(plot.nextElementSibling.textContent);
    try {
      await vegaEmbed(plot, spec, {renderer: 'svg', actions: false, config: styleFor(plot.clientWidth)});
    } catch (error) {
      plot.textContent = 'This chart could not be drawn; its table is below. ' + error;
      console.error(error);
    }
  }
  document.body.dataset.charts = 'drawn';
}

function sortKey(card, key) {
  const value = card.dataset[key];
  return key === 'reason' ? value : value === undefined ? Infinity : Number(value);
}

function startGallery(gallery) {
  const cards = [...gallery.querySelectorAll('.failure')];
  const place = new Map(cards.map((card, i) => [card, i]));
  const [reason, order] = ['reason', 'order'].map((name) => gallery.querySelector(`[name=${name}]`));
  const shown = gallery.querySelector('.shown');
  const show = () => {
    for (const card of cards) card.hidden = reason.value !== '' && card.dataset.reason !== reason.value;
    const [key, down] = order.value.split(' ');
    const sign = down ? -1 : 1;
    const compare = (a, b) => {
      const [x, y] = [sortKey(a, key), sortKey(b, key)];
      if (x === y) return place.get(a) - place.get(b);
      if (x === Infinity || y === Infinity) return x === Infinity ? 1 : -1;  // cards without the value are last
      return (x < y ? -1 : 1) * sign;
    };
    gallery.querySelector('.gallery').append(...[...cards].sort(compare));
    shown.textContent = `${cards.filter((card) => !card.hidden).length} shown`;
  };
  reason.addEventListener('change', show);
  order.addEventListener('change', show);
  show();
}

// A layer is the materials whose names begin with it.
async function showLayer(viewer, layer, visible) {
  for (const material of viewer.model?.materials ?? []) {
    if (!material.name.startsWith(layer)) continue;
    await material.ensureLoaded();
    const surface = material.pbrMetallicRoughness;
    material.shown ??= {mode: material.getAlphaMode(), color: [...surface.baseColorFactor]};
    material.setAlphaMode(visible ? material.shown.mode : 'MASK');
    const [r, g, b, alpha] = material.shown.color;
    surface.setBaseColorFactor([r, g, b, visible ? alpha : 0]);
  }
}

function startView(view) {
  const viewer = view.querySelector('model-viewer');
  const boxes = [...view.querySelectorAll('input[type=checkbox]')];
  const apply = () => boxes.forEach((box) => showLayer(viewer, box.value, box.checked));
  boxes.forEach((box) => box.addEventListener('change', apply));
  viewer.addEventListener('load', apply);
}

function startPick(pick) {
  const viewer = pick.querySelector('model-viewer');
  const button = pick.querySelector('button');
  const slider = pick.querySelector('input[type=range]');
  const clock = pick.querySelector('.note');
  const show = () => {
    const end = viewer.duration || 0;
    slider.value = end > 0 ? viewer.currentTime / end : 0;
    clock.textContent = `${viewer.currentTime.toFixed(1)} of ${end.toFixed(1)} s`;
    button.textContent = viewer.paused ? 'Play' : 'Pause';
  };
  button.addEventListener('click', () => { viewer.paused ? viewer.play() : viewer.pause(); show(); });
  slider.addEventListener('input', () => { viewer.pause(); viewer.currentTime = slider.value * viewer.duration; show(); });
  viewer.addEventListener('load', () => setInterval(show, 100));
}

document.querySelectorAll('.failures').forEach(startGallery);
document.querySelectorAll('.pick').forEach(startPick);
document.querySelectorAll('.view').forEach(startView);
// Paper gets the tables too, except long ones, whose charts show the same in less space.
const longTable = 15;
addEventListener('beforeprint', () => {
  for (const table of document.querySelectorAll('details')) {
    table.dataset.was = table.open;
    table.open ||= table.querySelectorAll('tr').length <= longTable;
  }
});
addEventListener('afterprint', () => {
  document.querySelectorAll('details').forEach((table) => { table.open = table.dataset.was === 'true'; });
});
drawCharts();
