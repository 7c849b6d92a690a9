// Opens a report file in headless Chromium and checks that it works.
//   node report_check.mjs PAGE.html [--views N] [--picks N] [--pictures DIR]
// --views, --picks: minimum number of 3D views and of animated picks on the page. --pictures: folder for screenshots and a PDF, for
// inspection by eye. Prints one line per fault and then exits with 1.

import {mkdirSync, writeFileSync} from 'node:fs';
import {join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

import {Browser} from '../support/browser.mjs';

const argument = (name) => {
  const place = process.argv.indexOf(name);
  return place < 0 ? undefined : process.argv[place + 1];
};
const page = resolve(process.argv[2]);
const views = Number(argument('--views') ?? 0);
const picks = Number(argument('--picks') ?? 0);
const pictures = argument('--pictures');

const faults = [];
const check = (right, what) => { if (!right) faults.push(what); };

async function checkCharts(browser) {
  const charts = await browser.value(`[...document.querySelectorAll('.plot')].map((plot) => ({
    name: plot.closest('[data-chart]').dataset.chart,
    marks: plot.querySelectorAll('.role-mark path, .role-mark text, .role-mark line').length,
    width: plot.querySelector('svg')?.getBoundingClientRect().width ?? 0,
    room: plot.getBoundingClientRect().width,
    table: plot.closest('figure').querySelectorAll('details tr').length}))`);
  check(charts.length >= 6, `only ${charts.length} charts`);
  for (const chart of charts) {
    check(chart.marks > 0, `chart ${chart.name} has no marks`);
    check(chart.width > 200 && chart.width <= chart.room + 1,
      `chart ${chart.name} is ${chart.width} px wide in ${chart.room} px`);
    check(chart.table > 1, `chart ${chart.name} has no table`);
  }
}

async function checkGallery(browser) {
  const state = () => browser.value(`(() => {
    const cards = [...document.querySelectorAll('.failure')].filter((card) => !card.hidden);
    return {reasons: cards.map((card) => card.dataset.reason),
      confidences: cards.map((card) => Number(card.dataset.confidence ?? -1)),
      seen: cards.filter((card) => card.getBoundingClientRect().height > 0).length,
      addresses: cards.every((card) => /#\\d+$/.test(card.querySelector('code').textContent)),
      said: document.querySelector('.shown').textContent};
  })()`);
  const choose = (name, value) => browser.value(`(() => {
    const list = document.querySelector('.failures [name=${name}]');
    list.value = ${JSON.stringify(value)};
    list.dispatchEvent(new Event('change'));
  })()`);
  const options = await browser.value(
    `[...document.querySelectorAll('.failures [name=reason] option')].map((option) => option.value)`);
  const all = await state();
  check(all.reasons.length > 0 && all.addresses, 'the gallery has no cards, or one without RUN#trial');
  for (const reason of options) {
    await choose('reason', reason);
    const {reasons, seen, said} = await state();
    const wanted = all.reasons.filter((name) => reason === '' || name === reason).length;
    check(wanted > 0 && reasons.length === wanted && seen === wanted && said === `${wanted} shown` &&
      (reason === '' || reasons.every((name) => name === reason)), `the filter '${reason}' is wrong`);
  }
  await choose('reason', '');
  await choose('order', 'confidence down');
  const {confidences} = await state();
  check(confidences.every((value, i) => i === 0 || value <= confidences[i - 1]),
    'the order by falling confidence is wrong');
  await choose('order', 'trial');
}

// Share of pixels that differ from the most frequent color, number of colors, and checksum of a view.
const drawn = `(async (viewer) => {
  const image = new Image();
  image.src = viewer.toDataURL('image/png');
  await image.decode();
  const canvas = Object.assign(document.createElement('canvas'), {width: image.width, height: image.height});
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  const pixels = new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer);
  const counts = new Map();
  let sum = 0;
  for (const pixel of pixels) {
    counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
    sum = (sum * 31 + pixel) >>> 0;
  }
  return {share: 1 - Math.max(...counts.values()) / pixels.length, colors: counts.size, sum};
})`;

async function checkView(browser, i) {
  const viewer = `document.querySelectorAll('.view model-viewer')[${i}]`;
  await browser.value(`${viewer}.scrollIntoView({block: 'center'})`);
  await browser.until(`${viewer}.loaded && ${viewer}.modelIsVisible`, `3D view ${i}`);
  const settle = () => browser.value(`new Promise((done) => {
    ${viewer}.jumpCameraToGoal();
    requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 200)));
  })`);
  await settle();
  const before = await browser.value(`${drawn}(${viewer})`);
  check(before.share > 0.05 && before.colors > 30, `3D view ${i} is blank: ${JSON.stringify(before)}`);
  await browser.value(`${viewer}.cameraOrbit = '120deg 30deg 90%'`);
  await browser.value(`${viewer}.updateComplete.then(() => true)`);
  await settle();
  const turned = await browser.value(`${drawn}(${viewer})`);
  check(turned.sum !== before.sum, `3D view ${i} does not rotate`);
  const layers = await browser.value(`${viewer}.closest('.view').querySelectorAll('input').length`);
  check(layers > 2, `3D view ${i} has no layers to choose`);
  await browser.value(`${viewer}.closest('.view').querySelectorAll('input').forEach((box) => {
    if (box.checked) box.click();
  })`);
  await settle();
  const hidden = await browser.value(`${drawn}(${viewer})`);
  check(hidden.share < 0.2 * turned.share, `3D view ${i} shows ${hidden.share} without layers`);
  await browser.value(`${viewer}.closest('.view').querySelectorAll('input').forEach((box) => box.click())`);
  await settle();
}

// An animated pick plays, stops at Pause, and goes to the time of the slider.
async function checkPick(browser, i) {
  const pick = `document.querySelectorAll('.pick')[${i}]`;
  const viewer = `${pick}.querySelector('model-viewer')`;
  await browser.value(`${viewer}.scrollIntoView({block: 'center'})`);
  await browser.until(`${viewer}.loaded && ${viewer}.duration > 1`, `animated pick ${i}`);
  await browser.until(`${viewer}.currentTime > 0.2`, `the motion of pick ${i}`);
  const click = `${pick}.querySelector('button').click()`;
  await browser.value(click);
  check(await browser.value(`${viewer}.paused`), `animated pick ${i} does not pause`);
  await browser.value(`(() => {
    const slider = ${pick}.querySelector('input');
    slider.value = 0.5;
    slider.dispatchEvent(new Event('input'));
  })()`);
  const share = await browser.value(`${viewer}.currentTime / ${viewer}.duration`);
  check(Math.abs(share - 0.5) < 0.05, `the slider of pick ${i} leads to ${share} of its time`);
  await browser.value(click);
  check(!await browser.value(`${viewer}.paused`), `animated pick ${i} does not go on`);
}

// Checks that nothing on a printed page is cut at its edge.
async function checkPaper(browser) {
  const paper_px = 718;  // A4 without its margins
  await browser.screen(paper_px, 'light');
  await browser.send('Emulation.setEmulatedMedia', {media: 'print'});
  const cut = await browser.value(`(() => {
    document.querySelectorAll('details').forEach((table) => { table.open = true; });
    return [...document.querySelectorAll('table, .plot svg')]
      .filter((one) => one.getBoundingClientRect().right > ${paper_px} + 1)
      .map((one) => one.textContent.trim().slice(0, 60));
  })()`);
  for (const one of cut) check(false, `cut at the edge of the printed page: ${one}`);
  await browser.send('Emulation.setEmulatedMedia', {media: ''});
}

async function run(browser) {
  await browser.open();
  browser.listeners.push(({method, params}) => {
    if (method === 'Runtime.exceptionThrown') {
      faults.push(`error: ${params.exceptionDetails.exception?.description ?? params.exceptionDetails.text}`);
    } else if (method === 'Runtime.consoleAPICalled' && ['error', 'warning'].includes(params.type)) {
      const text = params.args.map((arg) => arg.value ?? arg.description).join(' ');
      // On a busy machine, two frames take longer than the half second that model-viewer waits. It then
      // continues, and checkView tests whether the view is drawn.
      if (!text.startsWith('rAF timed out')) faults.push(`console: ${text}`);
    } else if (method === 'Log.entryAdded' && params.entry.level === 'error') {
      faults.push(`log: ${params.entry.text}`);
    } else if (method === 'Network.requestWillBeSent' && /^(https?|wss?):/.test(params.request.url)) {
      faults.push(`requests ${params.request.url} from the network`);
    }
  });
  for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await browser.send(`${domain}.enable`);
  await browser.screen(1280, 'light');
  await browser.send('Page.navigate', {url: pathToFileURL(page).href});
  await browser.until(`document.body?.dataset.charts === 'drawn'`, 'the charts');
  // Markup in names of the tests sets this variable if it runs.
  check(await browser.value(`window.injected === undefined`), 'markup in a name ran as code');
  await checkCharts(browser);
  if (await browser.value(`document.querySelector('.failures') !== null`)) await checkGallery(browser);
  const has = await browser.value(`document.querySelectorAll('.view model-viewer').length`);
  check(has >= views, `${has} 3D views instead of ${views}`);
  for (let i = 0; i < has; ++i) await checkView(browser, i);
  const animated = await browser.value(`document.querySelectorAll('.pick').length`);
  check(animated >= picks, `${animated} animated picks instead of ${picks}`);
  for (let i = 0; i < animated; ++i) await checkPick(browser, i);
  await browser.value('scrollTo(0, 0)');
  await browser.shot('light.png');
  await browser.screen(1280, 'dark');
  await browser.shot('dark.png');
  await browser.screen(400, 'light');
  await new Promise((done) => setTimeout(done, 1000));  // charts adapt to the new width
  const width = await browser.value('document.documentElement.scrollWidth');
  check(width <= 400, `on a phone of 400 px the page is ${width} px wide`);
  await browser.shot('phone.png');
  await checkPaper(browser);
  if (pictures) {
    await browser.screen(1280, 'dark');
    const {data} = await browser.send('Page.printToPDF', {printBackground: true});
    writeFileSync(join(pictures, 'print.pdf'), Buffer.from(data, 'base64'));
  }
}

if (pictures) mkdirSync(pictures, {recursive: true});
const browser = new Browser(pictures);
try {
  await run(browser);
} catch (error) {
  faults.push(String(error));
}
browser.close();
faults.forEach((fault) => console.error(fault));
process.exit(faults.length > 0 ? 1 : 0);
