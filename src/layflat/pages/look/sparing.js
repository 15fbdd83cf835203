// Spares the processor of a browser without a graphics device, which draws a scene by itself: a picture is drawn only
// once something has changed, and after a rest of twice as long as the last one took, so that drawing never takes more
// than a third of the time from the rest of the page. What is compared costs a hundredth of a picture.

const REST = 2; // after a picture, over the time that it took
const LOOK = 8; // between two looks whether a picture is complete, ms

export default {
  template: "<span hidden></span>",
  props: { scene: Number },
  async mounted() {
    await this.$nextTick(); // the scene's own element is known after it
    const found = getElement(this.scene);
    if (!found?.renderer) return; // the browser can't draw it, and says so there
    const draw = found.renderer.render.bind(found.renderer);
    const gl = found.renderer.getContext();
    let last = [];
    let free = 0; // when the next picture may begin, ms
    const wait = (fence, begun) => {
      if (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED)
        return setTimeout(wait, LOOK, fence, begun);
      gl.deleteSync(fence);
      free = performance.now() + REST * (performance.now() - begun);
    };
    found.renderer.render = (scene, camera) => {
      if (performance.now() < free) return;
      const now = seen(scene, camera, found.renderer.domElement);
      if (now.length === last.length && now.every((value, i) => value === last[i])) return;
      last = now;
      const begun = performance.now();
      draw(scene, camera);
      free = Infinity; // until it is complete
      const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      gl.flush(); // without which it may never be signalled
      wait(fence, begun);
    };
    for (const one of [found.text_renderer, found.text3d_renderer]) one?.domElement?.remove(); // wide as it once was
    found.text_renderer = found.text3d_renderer = { render() {}, setSize() {} }; // there are no texts
  },
};

function seen(scene, camera, canvas) {
  camera.updateMatrixWorld();
  const values = [canvas.width, canvas.height, ...camera.matrixWorld.elements, ...camera.projectionMatrix.elements];
  scene.traverseVisible((one) => {
    one.updateMatrix();
    values.push(one.id, ...one.matrix.elements);
    if (one.geometry) values.push(one.geometry.id, one.geometry.attributes.position?.version);
    if (one.material) values.push(look(one.material));
  });
  return values;
}

function look(material) {
  material.transparent = material.opacity < 1; // a scene's own are all so: drawn from the back, each part over others
  material.forceSinglePass = true; // both sides of a thin surface at once
  return `${material.color?.getHex()} ${material.opacity} ${material.side} ${material.map?.version}`;
}
