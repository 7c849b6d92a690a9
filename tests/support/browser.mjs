// Controls headless Chromium through its DevTools protocol over a pipe.

import {spawn} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

const wait_ms = 180000;  // limit for a page with software rendering on a busy machine

export class Browser {
  // `pictures`: folder for screenshots; none without it.
  constructor(pictures) {
    this.pictures = pictures;
    this.profile = mkdtempSync(join(tmpdir(), 'pickbed_chromium_'));
    this.process = spawn('chromium', [
      '--headless=new', '--no-sandbox', '--enable-unsafe-swiftshader', '--remote-debugging-pipe',
      '--disable-dev-shm-usage', '--hide-scrollbars', `--user-data-dir=${this.profile}`, 'about:blank',
    ], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
    this.process.on('error', (error) => { throw error; });
    this.answers = new Map();
    this.listeners = [];
    this.last = 0;
    let rest = '';
    this.process.stdio[4].on('data', (bytes) => {
      const messages = (rest + bytes).split('\0');
      rest = messages.pop();
      messages.forEach((text) => this.receive(JSON.parse(text)));
    });
  }
  receive(message) {
    if (message.id === undefined) return this.listeners.forEach((listen) => listen(message));
    const {done, failed} = this.answers.get(message.id);
    this.answers.delete(message.id);
    if (message.error) failed(new Error(message.error.message)); else done(message.result);
  }
  send(method, params = {}) {
    const id = ++this.last;
    this.process.stdio[3].write(JSON.stringify({id, method, params, sessionId: this.session}) + '\0');
    return new Promise((done, failed) => this.answers.set(id, {done, failed}));
  }
  async open() {
    const {targetId} = await this.send('Target.createTarget', {url: 'about:blank'});
    this.session = (await this.send('Target.attachToTarget', {targetId, flatten: true})).sessionId;
  }
  // Returns the value of an expression or promise in the page.
  async value(expression) {
    const {result, exceptionDetails} = await this.send('Runtime.evaluate',
      {expression, awaitPromise: true, returnByValue: true});
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? expression);
    return result.value;
  }
  async until(expression, what, limit_ms = wait_ms) {
    const end = Date.now() + limit_ms;
    while (!await this.value(expression)) {
      if (Date.now() > end) throw new Error(`timeout while waiting for ${what}`);
      await new Promise((done) => setTimeout(done, 100));
    }
  }
  async shot(name) {
    if (!this.pictures) return;
    const {data} = await this.send('Page.captureScreenshot', {captureBeyondViewport: true});
    writeFileSync(join(this.pictures, name), Buffer.from(data, 'base64'));
  }
  screen(width, scheme) {
    return Promise.all([
      this.send('Emulation.setDeviceMetricsOverride',
        {width, height: 900, deviceScaleFactor: 1, mobile: width < 600}),
      this.send('Emulation.setEmulatedMedia',
        {features: [{name: 'prefers-color-scheme', value: scheme}]}),
    ]);
  }
  close() {
    this.process.kill('SIGKILL');
    // Helper processes of Chromium still write into the profile for a moment. The retries of Node do not
    // cover a folder that fills again while it is emptied.
    const pause = new Int32Array(new SharedArrayBuffer(4));
    for (let tries = 0; ; ++tries) {
      try {
        rmSync(this.profile, {recursive: true, force: true});
        return;
      } catch (error) {
        if (tries === 50) throw error;
        Atomics.wait(pause, 0, 0, 100);
      }
    }
  }
}
