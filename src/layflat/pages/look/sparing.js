// Lets a scene be drawn only once it has changed: a browser without a graphics device draws it by itself, which takes
// half a core at ten pictures a second. What is compared costs a hundredth of that.

export default {
  template: "<span hidden></span>",
  props: { scene: Number },
  async mounted() {
    await this.$nextTick(); // the scene's own element is known after it
    const found = getElement(this.scene);
    if (!found?.renderer) return; // the browser can't draw it, and says so there
    const draw = found.renderer.render.bind(found.renderer);
    let last = [];
    found.renderer.render = (scene, camera) => {
      const now = seen(scene, camera, found.renderer.domElement);
      if (now.length === last.length && now.every((value, i) => value === last[i])) return;
      last = now;
      draw(scene, camera);
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
  return `${material.color?.getHex()} ${material.opacity} ${material.side} ${material.map?.version}`;
}
