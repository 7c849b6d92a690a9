// Opens a documentation site in headless Chromium, from disk as a reader does.
//   node check_site.mjs SITE HEADING WORD PAGE
// The front page must show HEADING, and its search box must find WORD on PAGE.html. Prints one line per fault
// and then exits with 1.

import {join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

import {Browser} from '../support/browser.mjs';

const [site, heading, word, page] = process.argv.slice(2);
const faults = [];

async function run(browser) {
  await browser.open();
  for (const domain of ['Page', 'Runtime']) await browser.send(`${domain}.enable`);
  await browser.screen(1280, 'light');
  await browser.send('Page.navigate', {url: pathToFileURL(join(resolve(site), 'index.html')).href});
  await browser.until(`document.readyState === 'complete'`, 'the front page');
  const shown = await browser.value(`document.querySelector('h1')?.innerText.trim() ?? ''`);
  if (!shown.startsWith(heading)) faults.push(`the heading is '${shown}' instead of '${heading}'`);
  const box = '[data-md-component=search-query]';
  await browser.value(`document.querySelector('${box}').focus()`);
  await browser.send('Input.insertText', {text: word});
  try {
    // On a loaded machine the search may start only after the word was entered, so the key is repeated. Each key
    // starts the search anew, so there is some time between two.
    const press = `document.querySelector('${box}').dispatchEvent(new KeyboardEvent('keyup', {bubbles: true}))`;
    const key = `(Date.now() < (window.pressed ?? 0) + 3000 || ((window.pressed = Date.now()), ${press}))`;
    const found = `document.querySelectorAll('.md-search-result__item a').length > 0`;
    const none = `document.querySelector('.md-search-result__meta')?.innerText.startsWith('No matching')`;
    await browser.until(`${key} && (${found} || ${none})`, 'search results', 40000);
    if (!(await browser.value(found))) return faults.push(`the search for '${word}' finds nothing`);
  } catch (error) {
    return faults.push(`the search for '${word}': ${error.message}`);
  }
  const links = await browser.value(`[...document.querySelectorAll('.md-search-result__item a')].map((a) => a.href)`);
  if (!links.some((link) => link.includes(`/${page}.html`))) {
    faults.push(`the search for '${word}' finds ${links.join(', ')} but not ${page}.html`);
  }
}

const browser = new Browser();
try {
  await run(browser);
} catch (error) {
  faults.push(String(error));
} finally {
  browser.close();
}
faults.forEach((fault) => console.log(fault));
process.exit(faults.length > 0 ? 1 : 0);
