// A worker for pages that are opened from disk: it runs in a hidden frame. The theme's search knows the name
// IFrameWorker and then waits for the scripts that it loads.
if (location.protocol === 'file:') {
  window.IFrameWorker = window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      this.waiting = [];
      const frame = document.createElement('iframe');
      frame.hidden = true;
      frame.srcdoc = '<!doctype html>';
      frame.addEventListener('load', () => this.start(frame.contentWindow, url), {once: true});
      document.body.append(frame);
    }
    start(inner, url) {
      this.inner = inner;
      inner.postMessage = (data) => this.dispatchEvent(new MessageEvent('message', {data}));
      inner.importScripts = (...urls) => urls.reduce((before, one) => before.then(() => this.load(one)), Promise.resolve());
      this.load(url).then(() => {
        this.ready = true;
        this.waiting.forEach((data) => this.postMessage(data));
      });
    }
    load(url) {
      const script = this.inner.document.createElement('script');
      script.src = url;
      return new Promise((done, failed) => {
        script.onload = done;
        script.onerror = failed;
        this.inner.document.body.append(script);
      });
    }
    postMessage(data) {
      if (!this.ready) return this.waiting.push(data);
      this.inner.dispatchEvent(new this.inner.MessageEvent('message', {data}));
    }
  };
}
