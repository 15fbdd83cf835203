// Renews the lease of who drives while this page is alive and in view, and tells which joints are being jogged.
// Buttons with `data-jog="joint:direction"` jog while they are held, by pointer or by key.

const EVERY = 50; // ms
const SILENT = 1000; // ms without a beat, after which this page does not drive: it renews nothing

export default {
  template: "<span hidden></span>",
  mounted() {
    this.seen = 0; // the last beat
    this.heard = -SILENT; // when, ms
    this.held = new Map(); // what holds a button (pointer or key), and the button
    this.listen = [
      [document, "pointerdown", (event) => this.press(`pointer ${event.pointerId}`, event.target, event)],
      [document, "pointerup", (event) => this.release(`pointer ${event.pointerId}`)],
      [document, "pointercancel", (event) => this.release(`pointer ${event.pointerId}`)],
      [document, "contextmenu", (event) => event.target.closest?.("[data-jog]") && event.preventDefault()],
      [document, "keydown", (event) => this.key(event)],
      [document, "keyup", (event) => this.release(`key ${event.code}`)],
      [document, "focusin", () => this.releaseKeys()],
      [window, "blur", (event) => event.target === window && this.releaseAll()],
      [document, "visibilitychange", () => this.releaseAll()],
    ];
    for (const [on, what, does] of this.listen) on.addEventListener(what, does, true);
    this.timer = setInterval(() => this.renew(), EVERY);
  },
  unmounted() {
    clearInterval(this.timer);
    for (const [on, what, does] of this.listen) on.removeEventListener(what, does, true);
  },
  methods: {
    beat(number) {
      this.$el.dataset.beat = this.seen = number;
      const silent = performance.now() - this.heard > SILENT;
      this.heard = performance.now();
      if (silent) this.renew(); // it drives from now on
    },
    key(event) {
      if (event.key === "Escape") this.$emit("stop");
      if ((event.key === " " || event.key === "Enter") && event.target.closest?.("[data-jog]")) {
        event.preventDefault();
        if (!event.repeat) this.press(`key ${event.code}`, event.target, event);
      }
    },
    press(by, target, event) {
      const button = target.closest?.("[data-jog]");
      if (!button || button.disabled || button.classList.contains("disabled") || event.button > 0) return;
      this.held.set(by, button);
      button.dataset.held = "";
      this.renew();
    },
    release(by) {
      const button = this.held.get(by);
      if (!button) return;
      this.held.delete(by);
      delete button.dataset.held;
      this.renew();
    },
    releaseKeys() {
      for (const by of [...this.held.keys()]) if (by.startsWith("key")) this.release(by);
    },
    releaseAll() {
      for (const by of [...this.held.keys()]) this.release(by);
    },
    renew() {
      if (document.hidden || !window.socket?.connected || performance.now() - this.heard > SILENT) return;
      const jogs = [...this.held.values()].filter((one) => one.isConnected).map((one) => one.dataset.jog);
      this.$emit("renew", { beat: this.seen, jogs });
    },
  },
};
